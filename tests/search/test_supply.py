from __future__ import annotations

import json

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.grammar import load_grammar, random_rules, rule_ids
from slcs2_jax.grammar.grammar import parse_grammar
from slcs2_jax.search import RuleSupply
from slcs2_jax.search.supply import BLOCK


def all_of(supply: RuleSupply, counts) -> dict[str, np.ndarray]:
    pieces = [supply.take(count) for count in counts]
    assert [len(piece["action"]) for piece in pieces] == list(counts)
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


@pytest.mark.parametrize("counts", [(9000,), (1, 0, 4095, 4904), (4096, 0, 4096, 808), (300,) * 30])
def test_the_sequence_does_not_depend_on_how_it_is_taken(make, counts):
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(3)))
    blocks = [make.source(BLOCK, rng) for _ in range(3)]
    taken = all_of(make.supply(3), counts)
    np.testing.assert_array_equal(taken["mask"], np.concatenate([mask for mask, _ in blocks])[:9000])
    np.testing.assert_array_equal(taken["action"], np.concatenate([action for _, action in blocks])[:9000])


@pytest.mark.parametrize("counts", [(), (5,), (BLOCK,), (BLOCK + 7, 20)])
def test_a_restored_supply_goes_on_exactly(make, counts):
    supply = make.supply(1)
    for count in counts:
        supply.take(count)
    resumed = make.supply(2)
    resumed.take(11)
    resumed.restore(json.loads(json.dumps(supply.state())))
    assert resumed.state() == supply.state()
    for count in (3, BLOCK, 50):
        here, there = supply.take(count), resumed.take(count)
        assert all(np.array_equal(here[name], there[name]) for name in here)


def test_a_source_that_draws_too_few_rules_is_refused(make):
    short = RuleSupply(lambda count, rng: make.source(count - 1, rng), np.random.SeedSequence(0))
    with pytest.raises(InputError, match="rule source returned"):
        short.take(1)


def test_it_supplies_the_rules_of_a_grammar():
    grammar = load_grammar("main")
    supply = RuleSupply(lambda count, rng: random_rules(grammar, count, rng), np.random.SeedSequence(0))
    taken = supply.take(100)
    assert taken["mask"].any(axis=1).all()
    assert len(np.unique(rule_ids(taken["mask"], taken["action"]))) > 50


def test_distinct_rules_are_those_that_come_first(make):
    plain, distinct = make.supply(1).take(3000), make.supply(1)
    ids = rule_ids(plain["mask"], plain["action"])
    first = list(dict.fromkeys(ids.tolist()))
    others = set(first[:10])
    taken = distinct.take_distinct(400, others)
    found = rule_ids(taken["mask"], taken["action"]).tolist()
    assert len(set(found)) == 400
    assert found == [one for one in first if one not in others][:400]


def test_a_source_of_too_few_rules_is_refused():
    grammar = parse_grammar("<rule> ::= packet held => collect from source | no packet held => send to si\n")
    supply = RuleSupply(lambda count, rng: random_rules(grammar, count, rng), np.random.SeedSequence(0))
    assert len(supply.take_distinct(2)["action"]) == 2
    with pytest.raises(InputError, match=r"accepted is a grammar with at least 3 different rules"):
        supply.take_distinct(3)
