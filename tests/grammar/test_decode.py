"""Decoding: worked by hand, against another implementation, the fast way against the readable one, and in the large."""

import math

import alogos
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar import (
    GRAMMARS,
    decode_rule,
    decode_rules,
    decode_words,
    load_grammar,
    parse_grammar,
    parse_rule_text,
    random_rule_sets,
    random_rules,
    rule_from_mask,
)
from slcs2_jax.grammar.vocabulary import PAPER

# codons and their rule, by hand from the paper's tables; c%k in the comments: codon c among k options
WORKED = [
    # Condition 4%5 Distance; Left 1%5 d_si; Operator 0%3 <; Right 4%5 net; Action 1%2 Networking; 1%2 Send; 1%5 si
    ("main", [4, 1, 0, 4, 1, 1, 1], "d_si < net => send to si"),
    # Condition 0%5 C & C; 2%5 Packet 0%2; 4%5 Distance 6%5, 3%3, 9%5; Action 3%2 Networking; 5%2 Send; 6%5 si
    ("main", [0, 2, 0, 4, 6, 3, 9, 3, 5, 6], "packet held & d_si < net => send to si"),
    # the same with big codons that leave the same remainders
    ("main", [255, 252, 254, 254, 251, 255, 254, 253, 251, 251], "packet held & d_si < net => send to si"),
    # Action 0%2 Move; Direction 2%3 orbit; target 6%7 obstacle
    ("main", [1, 0, 2, 6], "NI <= P_rs => orbit obstacle"),
    # Networking 0%2 Collect: a single option, no codon
    ("main", [3, 1, 1, 0], "no node in reach => collect from source"),
    # clauses are sorted: Distance first, then NI
    ("main", [0, 4, 3, 2, 3, 1, 0, 1, 5], "NI <= P_rs & d_sink = d_th => move away from jammer"),
    # duplicates are dropped
    ("main", [0, 2, 1, 2, 1, 0, 0, 4], "no packet held => move toward sink"),
    # wrapped once: 2%5 Packet, 1%2; Action 2%2 Move; Direction 1%3 away; codons out: target's first
    ("main", [2, 1], "no packet held => move away from so"),
    # 0%5 C & C twice, then out: NI for all three; Move and Collect are both three expansions long, the first wins
    ("main", [0], "NI <= P_rs => move toward so"),
    # Noise: no codon, Channel 4%3 is 6; Action 1, Collect 0, Channel 2%3 is 11
    ("channel", [1, 4, 1, 0, 2], "noise on 6 <= P_rs => collect from source on 11"),
    # Right has six options: 5%6 xi; Send, target 9%5 sink, Channel 1%3 is 6
    ("channel", [4, 4, 1, 5, 1, 1, 9, 1], "d_source > xi => send to sink on 6"),
    ("channel", [1, 0, 1, 1, 1, 0], "NI <= P_rs => send to si"),  # channel 1 goes unsaid
    # Power 0%2 half
    ("power", [4, 0, 2, 11, 1, 1, 4, 0], "d_so = xi => send to sink at half power"),
    ("power", [1, 1, 0, 1], "NI <= P_rs => collect from source"),  # full power goes unsaid
    # target 2%5 c, Channel 5%3 is 11, Power 7%2 full; then the same with 6%2 half
    ("both", [3, 1, 1, 1, 2, 5, 7], "no node in reach => send to c on 11"),
    ("both", [3, 1, 1, 1, 2, 5, 6], "no node in reach => send to c on 11 at half power"),
    ("both", [1, 2, 1, 0, 1, 0], "noise on 11 <= P_rs => collect from source on 6 at half power"),
]


@pytest.mark.parametrize(("name", "codons", "text"), WORKED)
def test_worked_examples(name, codons, text):
    grammar = load_grammar(name)
    assert decode_rule(grammar, codons).text() == text
    mask, action = decode_rules(grammar, np.array([codons]))
    assert rule_from_mask(mask[0], int(action[0])).text() == text


def test_single_option_consumes():
    """Condition 4; Distance (one option) takes 99; Left 1; < 0; net 4; Action 1; Networking 1; Send (one option)
    takes 77; si 1."""
    grammar = load_grammar("main", single_option_consumes=True)
    assert decode_rule(grammar, [4, 99, 1, 0, 4, 1, 1, 77, 1]).text() == "d_si < net => send to si"


def test_limit_on_clauses():
    """Seven times C & C make eight clauses; from then on a condition chooses among the other four: 0 NI, 1 Packet, 2
    Node, 3 Distance."""
    codons = [0] * 7 + [1, 0, 1, 1, 2, 0, 2, 1, 4, 3, 0, 0, 0, 3, 1, 0, 0, 7, 2, 0, 0, 0, 2, 6]
    rule = decode_rule(load_grammar("main"), codons)
    plain = "NI <= P_rs & packet held & no packet held & node in reach & no node in reach"
    assert rule.text() == f"{plain} & d_so < d_so & d_si < d_so & d_c < d_so => orbit obstacle"
    one = load_grammar("main", max_clauses=1)
    assert decode_rule(one, [0, 1, 0]).text() == "NI <= P_rs => collect from source"


def test_a_single_option_left_by_the_limit_takes_no_codon():
    text = "<R> ::= <C> => <A>\n<C> ::= <C> & <C> | packet held\n<A> ::= orbit so | orbit si\n"
    assert decode_rule(parse_grammar(text, max_clauses=2), [0, 1]).text() == "packet held => orbit si"
    assert (
        decode_rule(parse_grammar(text, max_clauses=2, single_option_consumes=True), [0, 9, 8, 1]).text()
        == "packet held => orbit si"
    )


def test_when_codons_run_out_the_fewest_clauses_win():
    """<A> -> <B> is two expansions and <A> -> two clauses only one; without a limit on clauses <A>, <B>, <A>, ...
    would never end."""
    text = """<R> ::= <A> => orbit so
    <A> ::= <B> | node in reach & node in reach
    <B> ::= <A> | <X>
    <X> ::= <Y> | <A>
    <Y> ::= packet held"""
    assert decode_rule(parse_grammar(text, max_clauses=1), [0]).text() == "packet held => orbit so"


@pytest.mark.parametrize("codons", [[], [256], [-1], [1.0], ["1"], [True], [None], [1, 2, 300]])
def test_codons_refused(codons):
    with pytest.raises(InputError, match="codons"):
        decode_rule(load_grammar("main"), codons)


@pytest.mark.parametrize(
    "codons",
    [
        np.zeros(3, int),
        np.zeros((2, 0), int),
        np.zeros((2, 3)),
        np.array([[256]]),
        np.array([[-1]]),
        np.array([[True]]),
    ],
)
def test_codon_arrays_refused(codons):
    with pytest.raises(InputError, match="codons"):
        decode_rules(load_grammar("main"), codons)


def test_no_rules():
    mask, action = decode_rules(load_grammar("main"), np.zeros((0, 5), np.uint8))
    assert (mask.shape, action.shape) == ((0, 4), (0,))


def assert_equal(grammar, codons):
    mask, action = decode_rules(grammar, codons)
    rules = [decode_rule(grammar, row) for row in codons]
    np.testing.assert_array_equal(mask, [rule.mask() for rule in rules])
    np.testing.assert_array_equal(action, [rule.action for rule in rules])


@pytest.mark.parametrize("length", [1, 2, 3, 7, 40])
@pytest.mark.parametrize("name", GRAMMARS)
def test_fast_equals_readable(name, length):
    codons = np.random.default_rng(length).integers(0, 256, (500, length), np.uint8)
    for settings_ in ({}, {"max_clauses": 2}, {"single_option_consumes": True}):
        assert_equal(load_grammar(name, **settings_), codons)


def test_fast_equals_readable_at_the_limit():
    """Codons that are mostly multiples of 5 choose C & C again and again."""
    rng = np.random.default_rng(3)
    codons = np.where(
        rng.random((1000, 40)) < 0.7, 5 * rng.integers(0, 52, (1000, 40)), rng.integers(0, 256, (1000, 40))
    )
    words = [decode_words(load_grammar("main"), row) for row in codons[:200]]
    counts = [row.count("&") + 1 for row in words]
    assert max(counts) == 8
    assert counts.count(8) > 50
    for limit in (3, 8, 64):
        assert_equal(load_grammar("main", max_clauses=limit), codons)


CLAUSE_PARTS = ["packet held", "node in reach", "d_si < net", "<C0>", "<C1>", "<C2>", "<Left> = <Right>"]
ACTION_PARTS = ["orbit so", "send to <T>", "send to <T> on 6", "<A0>", "<A1>"]
conditions = st.lists(
    st.lists(st.sampled_from(CLAUSE_PARTS), min_size=1, max_size=4).map(" & ".join), min_size=1, max_size=4
)
actions = st.lists(st.sampled_from(ACTION_PARTS), min_size=1, max_size=3)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(conditions, min_size=3, max_size=3), st.lists(actions, min_size=2, max_size=2),
    st.integers(1, 9), st.booleans(), st.integers(1, 12), st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_fast_equals_readable_for_any_grammar(condition, action, max_clauses, consumes, length, seed):
    lines = ["<R> ::= <C0> => <A0>", "<Left> ::= d_so | d_sink", "<Right> ::= d_th", "<T> ::= si | sink"]
    lines += [f"<C{k}> ::= {' | '.join(found)}" for k, found in enumerate(condition)]
    lines += [f"<A{k}> ::= {' | '.join(found)}" for k, found in enumerate(action)]
    try:
        grammar = parse_grammar("\n".join(lines), max_clauses=max_clauses, single_option_consumes=consumes)
    except InputError as error:
        assert "terminate" in str(error) or "max_clauses" in str(error)  # noqa: PT017
        assume(False)
    codons = np.random.default_rng(seed).integers(0, 256, (20, length))
    assert_equal(grammar, codons)
    words = [decode_words(grammar, row) for row in codons]
    assert max(row.count("&") + 1 for row in words) <= max_clauses
    mask, action_numbers = decode_rules(grammar, codons)
    assert set(action_numbers.tolist()) <= set(grammar.actions)
    for row, number in zip(mask, action_numbers, strict=True):
        assert set(rule_from_mask(row, int(number)).clauses) <= set(grammar.clauses)


# alogos imports its parser late, and that imports a deprecated module of the standard library
QUIET = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def alogos_grammar(grammar):
    """The same grammar for alogos, which wants its terminals apart: every word becomes 'word '."""
    lines = []
    for production in grammar.productions.values():
        found = [
            "".join(f"'{s} '" if isinstance(s, str) else f"<{s.name}>" for s in o.body) for o in production.options
        ]
        lines.append(f"<{production.name}> ::= {' | '.join(found)}")
    return alogos.Grammar(bnf_text="\n".join(lines), start_terminal_symbol="'", end_terminal_symbol="'")


@QUIET
@pytest.mark.parametrize("length", [3, 6, 40])
@pytest.mark.parametrize("name", GRAMMARS)
def test_against_alogos(name, length):
    """alogos maps as we do if a single option takes no codon and clauses are unlimited, until it gives up at the second
    wrap and we go on."""
    free, limited = load_grammar(name, max_clauses=64), load_grammar(name)
    other = alogos_grammar(free)
    compared = 0
    for codons in np.random.default_rng(length).integers(0, 256, (600, length)).tolist():
        try:
            text = alogos.systems.ge.mapping.forward(other, codons, {"max_wraps": 1, "max_expansions": None})
        except alogos.exceptions.MappingError:
            continue
        assert " ".join(decode_words(free, codons)) == text.strip()
        if text.count("&") + 1 < limited.max_clauses:
            assert decode_rule(limited, codons) == parse_rule_text(text)
        compared += 1
    assert compared > 200


@QUIET
def test_against_alogos_where_single_options_consume():
    """The other convention by way of alogos: each single option written twice makes a choice of two equal ones.
    alogos keeps duplicates apart only if they differ, so the second gets a space more."""
    grammar = load_grammar("both", single_option_consumes=True)
    lines = []
    for production in grammar.productions.values():
        found = [
            "".join(f"'{s} '" if isinstance(s, str) else f"<{s.name}>" for s in o.body) for o in production.options
        ]
        if len(found) == 1 and production.name != grammar.start:
            found.append(found[0] + "' '")
        lines.append(f"<{production.name}> ::= {' | '.join(found)}")
    other = alogos.Grammar(bnf_text="\n".join(lines), start_terminal_symbol="'", end_terminal_symbol="'")
    compared = 0
    for codons in np.random.default_rng(5).integers(0, 256, (300, 40)).tolist():
        text = alogos.systems.ge.mapping.forward(
            other, codons, {"max_wraps": 1, "max_expansions": None}, raise_errors=False
        )
        if "<" not in text.replace(" < ", "").replace("<=", "") and text.count("&") < 8:
            assert " ".join(decode_words(grammar, codons)) == " ".join(text.split())
            compared += 1
    assert compared > 250


def leaf_series(z, branch, leaf):
    """Probability that every clause of a random condition lies in a set that a clause lies in with probability z: the
    root of G = leaf * z + branch * G^2."""
    return (1 - math.sqrt(1 - 4 * branch * leaf * z)) / (2 * branch)


def test_shares_of_clauses_and_actions():
    """256 codons over 5 options: 52, 51, 51, 51, 51; so C & C has 52/256 and each kind of clause a quarter of the
    rest."""
    count = 200_000
    mask, action = random_rules(load_grammar("main"), count, np.random.default_rng(11))
    branch, leaf = 52 / 256, 204 / 256

    def check(measured, expected):
        assert abs(measured - expected) < 5 * math.sqrt(expected * (1 - expected) / count) + 2e-4

    bits = np.unpackbits(mask.view(np.uint8), axis=1, bitorder="little")[:, :97].astype(bool)
    kinds = np.array([clause.kind for clause in PAPER.clauses])
    groups = {
        "noise": ("noise",),
        "packet": ("packet", "no_packet"),
        "held": ("packet",),
        "node": ("node", "no_node"),
        "distance": ("distance",),
    }
    for name, members in groups.items():
        only = ~bits[:, ~np.isin(kinds, members)].any(axis=1)
        check(only.mean(), leaf_series(1 / 8 if name == "held" else 1 / 4, branch, leaf))
    check((bits.sum(axis=1) > 0).mean(), 1)
    assert not bits[:, 80:].any()
    found = [PAPER.actions[k] for k in range(57)]
    check(np.isin(action, [k for k, a in enumerate(found) if a.kind == "move"]).mean(), 1 / 2)
    check(np.isin(action, [k for k, a in enumerate(found) if a.kind == "collect"]).mean(), 1 / 4)
    check(np.isin(action, [k for k, a in enumerate(found) if a.kind == "send" and a.target == 0]).mean(), 52 / 256 / 4)
    check(np.isin(action, [k for k, a in enumerate(found) if a.direction == 0]).mean(), 86 / 256 / 2)
    check(np.isin(action, [k for k, a in enumerate(found) if a.kind == "move" and a.target == 6]).mean(), 36 / 256 / 2)


def test_half_power_is_half():
    """The paper: about half of the communication rules of the power grammar are at half power at first."""
    _, action = random_rules(load_grammar("power"), 100_000, np.random.default_rng(2))
    power = np.array([a.power for a in PAPER.actions])[action]
    assert abs((power[power >= 0] == 0).mean() - 0.5) < 0.01


def test_random_rules_depend_on_the_generator_alone():
    grammar = load_grammar("both")
    one, two = (random_rules(grammar, 9000, np.random.default_rng(4)) for _ in range(2))
    np.testing.assert_array_equal(one[0], two[0])
    np.testing.assert_array_equal(one[1], two[1])
    first = decode_rules(grammar, np.random.default_rng(4).integers(0, 256, (9000, 40), np.uint8)[8190:8195])
    np.testing.assert_array_equal(first[0], one[0][8190:8195])
    sets = random_rule_sets(grammar, 9, 1000, np.random.default_rng(4))
    np.testing.assert_array_equal(sets.mask.reshape(-1, 4), one[0])


def test_random_rules_refused():
    grammar, rng = load_grammar("main"), np.random.default_rng(0)
    for count, codons in ((-1, 40), (1, 0), (1, 1025)):
        with pytest.raises(InputError, match=r"count|codons"):
            random_rules(grammar, count, rng, codons=codons)
