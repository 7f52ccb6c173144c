"""Rules and rule-sets: equality, words, hashes, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar import (
    GRAMMARS,
    Rule,
    RuleSets,
    load_grammar,
    make_rule,
    parse_rule_text,
    random_rule_sets,
    random_rules,
    rule_from_mask,
    rule_ids,
)
from slcs2_jax.grammar.vocabulary import PAPER


def test_order_and_duplicates_do_not_matter():
    one = parse_rule_text("d_si<net & packet held&d_si < net => send to si on 1 at full power")
    assert one == Rule((1, 24), 34) == make_rule([24, 1, 24], 34)
    assert one.text() == "packet held & d_si < net => send to si"
    np.testing.assert_array_equal(one.mask(), [(1 << 1) | (1 << 24), 0, 0, 0])
    np.testing.assert_array_equal(make_rule([31, 32, 95, 96], 0).mask(), [1 << 31, 1, 1 << 31, 1])


@settings(max_examples=300)
@given(st.sets(st.integers(0, len(PAPER.clauses) - 1), min_size=1, max_size=10), st.integers(0, len(PAPER.actions) - 1))
def test_every_rule_round_trips(clauses, action):
    rule = make_rule(clauses, action)
    assert parse_rule_text(rule.text()) == rule
    assert rule_from_mask(rule.mask(), rule.action) == rule


@pytest.mark.parametrize("name", GRAMMARS)
def test_random_rule_sets_round_trip(name):
    sets = random_rule_sets(load_grammar(name), 3, 50, np.random.default_rng(1))
    texts = [[sets.text(i, r) for r in range(50)] for i in range(3)]
    again = RuleSets.from_rules([[parse_rule_text(text) for text in row] for row in texts])
    np.testing.assert_array_equal(again.mask, sets.mask)
    np.testing.assert_array_equal(again.action, sets.action)
    np.testing.assert_array_equal(again.ids(), sets.ids())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not of the form"),
        ("packet held", "not of the form"),
        ("packet held => orbit so => orbit si", "not of the form"),
        ("=> orbit so", "clause: '' is not known"),
        ("packet held & => orbit so", "clause: '' is not known"),
        ("packet lost => orbit so", "clause: 'packet lost' is not known"),
        ("packet held => fly", "action: 'fly' is not known"),
        ("packet held =>", "action: '' is not known"),
    ],
)
def test_rule_text_refused(text, message):
    with pytest.raises(InputError, match=message):
        parse_rule_text(text)


@settings(max_examples=200)
@given(st.text(max_size=60))
def test_random_rule_text_never_raises_anything_else(text):
    reason = ""
    try:
        parse_rule_text(text)
    except InputError as error:
        reason = str(error)
    assert reason.isprintable()


def test_ids_are_equal_exactly_for_equal_rules():
    mask, action = random_rules(load_grammar("both"), 100_000, np.random.default_rng(8))
    ids = rule_ids(mask, action)
    assert ids.dtype == np.uint64
    rows = np.column_stack([mask, action.astype(np.uint32)])
    assert len(np.unique(ids)) == len(np.unique(rows, axis=0))
    np.testing.assert_array_equal(rule_ids(mask[5], action[5]), ids[5])
    np.testing.assert_array_equal(
        rule_ids(mask.reshape(100, 1000, 4), action.reshape(100, 1000)), ids.reshape(100, 1000)
    )


def test_ids_are_these_for_ever():
    """Run folders may hold ids, so the hash must not change; computed here with Python's own integers."""
    full = (1 << 64) - 1

    def finish(x):
        x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9 & full
        x = (x ^ (x >> 27)) * 0x94D049BB133111EB & full
        return x ^ (x >> 31)

    rule = parse_rule_text("packet held & noise on 11 <= P_rs => send to si")
    step = 0x9E3779B97F4A7C15
    h = finish(34 + step)
    h = finish(((h ^ (1 << 1)) + step) & full)
    h = finish(((h ^ (1 << 32)) + step) & full)
    assert int(rule_ids(rule.mask(), np.uint8(rule.action))) == h


def test_id_bits_are_balanced():
    mask, action = random_rules(load_grammar("main"), 50_000, np.random.default_rng(9))
    ids = np.unique(rule_ids(mask, action))
    shares = [((ids >> np.uint64(bit)) & np.uint64(1)).mean() for bit in range(64)]
    assert max(abs(share - 0.5) for share in shares) < 5 * 0.5 / np.sqrt(len(ids))


def good():
    return np.ones((2, 3, 4), np.uint32), np.zeros((2, 3), np.uint8)


def test_rule_sets_refused():
    mask, action = good()
    RuleSets(mask, action)
    empty, beyond, unknown = mask.copy(), mask.copy(), action.copy()
    empty[1, 2] = 0
    beyond[0, 0, 3] = 2
    unknown[1, 1] = 57
    cases = [
        (mask.astype(np.int64), action, "dtypes"),
        (mask, action.astype(int), "dtypes"),
        (mask[:, :2], action, "shapes"),
        (mask[0], action[0], "shapes"),
        (mask[..., :3], action, "shapes"),
        (empty, action, "no clause"),
        (beyond, action, "beyond clause 96"),
        (mask, unknown, "action 57"),
    ]
    for bad_mask, bad_action, message in cases:
        with pytest.raises(InputError, match=message):
            RuleSets(bad_mask, bad_action)


def test_rules_refused():
    for clauses, action in (([], 0), ([97], 0), ([-1], 0), ([1], 57), ([1], 255)):
        with pytest.raises(InputError):
            make_rule(clauses, action)
    with pytest.raises(InputError, match="equally many"):
        RuleSets.from_rules([[make_rule([1], 0)], []])
    with pytest.raises(InputError, match="equally many"):
        RuleSets.from_rules([])
