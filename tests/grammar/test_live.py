"""Rules that can never hold are told from the rest by what their clauses say."""

from __future__ import annotations

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax.config import InputError
from slcs2_jax.grammar import RuleSets, load_grammar, parse_rule_text, random_rules
from slcs2_jax.grammar.grammar import parse_grammar
from slcs2_jax.grammar.live import Bounds, can_hold, live_rules

BOUNDS = Bounds.of(slcs2.Settings())  # d_th = 50 m, network range about 163 m


@pytest.mark.parametrize(
    ("condition", "alive"),
    [
        ("packet held & no packet held", False),
        ("node in reach & no node in reach", False),
        ("packet held & node in reach & NI <= P_rs", True),
        ("d_so < d_so", False),
        ("d_so = d_so", True),
        ("d_so < d_si & d_so > d_si", False),
        ("d_so < d_si & d_so = d_si", True),  # the tolerance of = excludes neither
        ("d_so < d_si & d_si < d_th & d_source > d_th", True),
        ("d_so < d_si & d_si < d_th & d_so > d_th", False),  # a circle of three
        ("d_c > d_so", False),  # nobody is closer than the closest
        ("d_sink < d_si", False),
        ("d_sink > d_si", True),
        ("d_si > net & d_si < d_th", False),  # by the values of the two
        ("d_si = net & d_si < d_th", False),
        ("d_si = net & d_si > d_th", True),
        ("d_sink > xi & d_sink < xi", False),
    ],
)
def test_conditions_that_contradict_themselves(condition, alive):
    rule = parse_rule_text(f"{condition} => collect from source")
    assert can_hold(rule.mask()[None], rule.vocabulary, BOUNDS).tolist() == [alive]


def test_a_larger_threshold_brings_others_to_life():
    rule = parse_rule_text("d_si > net & d_si < d_th => collect from source")
    wide = Bounds.of(slcs2.Settings(swarm=slcs2.Swarm(distance_threshold=500.0)))
    assert can_hold(rule.mask()[None], rule.vocabulary, wide).all()


def test_what_cannot_hold_never_acts():
    grammar = load_grammar("both")
    mask, action = random_rules(grammar, 20_000, np.random.default_rng(0))
    alive = can_hold(mask, grammar.vocabulary, BOUNDS)
    assert 0.05 < 1 - alive.mean() < 0.12
    settings = slcs2.Settings(
        world=slcs2.World.preset("urban_jammed"),
        swarm=slcs2.Swarm(agents=6),
        rules=slcs2.Rules(grammar="both", rules=200),
        compute=slcs2.Compute(devices=1),
    )
    settings = slcs2.Settings(**vars(settings) | {"world": slcs2.World(**vars(settings.world) | {"time_limit": 500})})

    def usage(which: np.ndarray) -> np.ndarray:
        chosen = np.flatnonzero(which)[: 6 * 200]
        rules = RuleSets(mask[chosen].reshape(6, 200, -1), action[chosen].reshape(6, 200), grammar.vocabulary)
        [one] = slcs2.deploy(settings, slcs2.make_scenario(settings, 3), rules)
        return one.figures.usage

    assert not usage(~alive).any()
    assert usage(alive).any()


def test_live_rules_are_as_many_and_as_random_as_wanted():
    grammar = load_grammar("main")
    mask, action = live_rules(grammar, 500, np.random.default_rng(1), codons=40, bounds=BOUNDS)
    assert len(mask) == len(action) == 500
    assert can_hold(mask, grammar.vocabulary, BOUNDS).all()
    every, _ = random_rules(grammar, 500, np.random.default_rng(1))
    kept = every[can_hold(every, grammar.vocabulary, BOUNDS)]
    np.testing.assert_array_equal(mask[: len(kept)], kept)


def test_a_grammar_of_dead_rules_is_refused():
    text = "<rule> ::= d_so < d_so => collect from source | d_c > d_c => collect from source\n"
    with pytest.raises(InputError, match=r"rules\.distinct=true: accepted is a grammar of which most rules can hold"):
        live_rules(parse_grammar(text), 5, np.random.default_rng(0), codons=4, bounds=BOUNDS)
