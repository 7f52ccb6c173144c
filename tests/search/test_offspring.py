from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.grammar import load_grammar, random_rules, rule_ids
from slcs2_jax.search import Origin, RuleSupply, offspring
from slcs2_jax.search.offspring import (
    donor_weights,
    draw_exchange,
    greatest_strength,
    kept_count,
    low_quality,
    lowest_error,
)


@pytest.mark.parametrize(
    ("contribution", "low"),
    [
        ([3, 1, 2], [0, 1, 0]),  # at the mean is high
        ([0, 0, 5], [1, 1, 0]),
        ([0, 0, 0], [1, 1, 1]),  # the deviation
        ([4, 4, 4], [1, 1, 1]),
        ([5, 5, 4], [0, 0, 1]),
    ],
)
def test_low_quality(contribution, low):
    assert low_quality(np.array(contribution)).tolist() == [bool(one) for one in low]


@pytest.mark.parametrize(
    ("contribution", "receivers", "expected"),
    [
        ([3, 1, 2], [1], [[3, 0, 2]]),
        ([0, 0, 5], [0, 1], [[0, 0, 5], [0, 0, 5]]),
        ([0, 0, 0], [0, 1, 2], [[0, 0, 0]] * 3),
        ([4, 4, 4], [0, 1, 2], [[0, 4, 4], [4, 0, 4], [4, 4, 0]]),  # nobody gives to itself
    ],
)
def test_donor_weights(contribution, receivers, expected):
    assert donor_weights(np.array(contribution), np.array(receivers)).tolist() == expected


@pytest.mark.parametrize(
    ("rules", "fitness", "explorations", "varrho", "kept"),
    [
        (100, 0.5, 0, 100, 25),
        (100, 0.58, 0, 100, 29),  # 100 * 0.29 is 28.999999999999996
        (100, 0.579, 0, 100, 28),
        (100, 0.5, 10, 100, 15),
        (100, 0.5, 25, 100, 0),
        (100, 0.5, 26, 100, 0),  # never below none
        (100, -0.5, 0, 100, 0),
        (100, 0.999, 0, 100, 49),  # at most half: never the paper's max(1, .), which would keep all
        (7, 0.9, 1, 10, 2),  # 7 * 0.35 = 2.45
        (4, 2.0, 0, 100, 4),
        (4, 9.0, 0, 100, 4),
    ],
)
def test_how_many_are_kept(rules, fitness, explorations, varrho, kept):
    assert kept_count(rules, fitness, explorations, varrho) == kept


def test_lowest_error_takes_used_rules_first_and_breaks_ties_by_index():
    error = np.array([[0.5, 0.0, 0.2, 0.2, 0.0]])
    used = np.array([[True, False, True, True, False]])
    assert lowest_error(error, used).tolist() == [[2, 3, 0, 1, 4]]


def test_greatest_strength_breaks_ties_by_index():
    assert greatest_strength(np.array([[0.0, 2.0, -1.0, 2.0, 0.0]])).tolist() == [[1, 3, 0, 4, 2]]


def test_donors_are_drawn_in_proportion_and_shares_evenly():
    contribution, receivers = np.array([30, 0, 10, 0, 0, 1]), np.array([1] * 20_000)
    donors, count = draw_exchange(contribution, receivers, 10, np.random.default_rng(0))
    share = np.bincount(donors, minlength=6) / receivers.size
    assert share == pytest.approx([0.75, 0, 0.25, 0, 0, 0], abs=0.015)
    assert set(count.tolist()) == set(range(10))  # floor(10 U): never all ten
    assert np.bincount(count) / receivers.size == pytest.approx(0.1, abs=0.01)


def test_without_contribution_nothing_is_copied():
    _, count = draw_exchange(np.zeros(3, int), np.arange(3), 10, np.random.default_rng(0))
    assert count.tolist() == [0, 0, 0]


def child_of(make, parent, evaluation, *, explorations=0, varrho=100.0, exchange=True, generation=5, seed=1):
    return offspring(
        parent,
        evaluation,
        explorations=explorations,
        generation=generation,
        varrho=varrho,
        exchange=exchange,
        supply=make.supply(seed),
        rng=np.random.default_rng(seed),
    )


def test_a_worked_child(make):
    """Fitness 0.8 of 5 rules keeps 2; agent 1 (contribution 0) evolves with agent 0 (6) or agent 2 (3) as donor."""
    parent = make.solution(agents=3, rules=5, generation=4)
    error = np.array([[0.0] * 5, [0.4, 0.1, 0.3, 0.2, 0.0], [0.0] * 5])
    usage = np.array([[1] * 5, [1, 1, 1, 1, 0], [1] * 5])  # rule 4 was never used
    strength = np.array([[1, 5, 3, 2, 4], [9] * 5, [5, 4, 3, 2, 1]], float)
    evaluation = make.evaluation(0.8, (6, 0, 3), rules=5, error=error, usage=usage, strength=strength)
    donors, sizes = set(), set()
    for seed in range(40):
        child = child_of(make, parent, evaluation, seed=seed)
        for agent in (0, 2):
            for name, array in child.arrays().items():
                np.testing.assert_array_equal(array[agent], parent.arrays()[name][agent])
        np.testing.assert_array_equal(child.ids[1, :2], parent.ids[1, [1, 3]])
        assert child.origin_kind[1, :2].tolist() == [Origin.INITIAL] * 2
        assert child.origin_generation[1, :2].tolist() == [0, 0]
        copied = child.origin_kind[1] == Origin.COPIED
        size = int(copied.sum())
        assert copied[2 : 2 + size].all()
        assert size < 3  # U(0, 1) < 1: at least one new rule
        if size:
            donor = int(child.origin_agent[1, 2])
            best = {0: [1, 4, 2], 2: [0, 1, 2]}[donor][:size]
            np.testing.assert_array_equal(child.ids[1, copied], parent.ids[donor, best])
            np.testing.assert_array_equal(child.rules.mask[1, copied], parent.rules.mask[donor, best])
            assert (child.origin_agent[1, copied] == donor).all()
            donors.add(donor)
        assert (child.origin_kind[1, 2 + size :] == Origin.RANDOM).all()
        assert (child.origin_agent[1, 2 + size :] == -1).all()
        assert (child.origin_generation[1, 2:] == 5).all()
        sizes.add(size)
        assert (child.generation, child.parent) == (5, 4)
    assert donors == {0, 2}
    assert sizes == {0, 1, 2}


def test_exchange_off_copies_nothing_but_keeps_the_best(make):
    parent = make.solution(agents=3, rules=10)
    evaluation = make.evaluation(0.8, (6, 0, 3), rules=10)
    for seed in range(5):
        child = child_of(make, parent, evaluation, exchange=False, seed=seed)
        assert not (child.origin_kind == Origin.COPIED).any()
        assert (child.origin_kind[1] == Origin.RANDOM).sum() == 6
        np.testing.assert_array_equal(child.ids[1, :4], parent.ids[1, :4])


def test_explorations_shrink_what_is_kept(make):
    parent = make.solution(agents=2, rules=10)
    evaluation = make.evaluation(0.8, (6, 0), rules=10)
    for explorations, kept in ((0, 4), (10, 3), (40, 0), (70, 0)):
        child = child_of(make, parent, evaluation, explorations=explorations, exchange=False)
        assert (child.origin_kind[1] == Origin.INITIAL).sum() == kept


def test_while_nothing_is_delivered_everything_is_new(make):
    parent = make.solution(agents=3, rules=6)
    child = child_of(make, parent, make.evaluation(-1.0, (0, 0, 0), rules=6))
    assert (child.origin_kind == Origin.RANDOM).all()
    assert not (child.ids == parent.ids).all()


def test_equal_contributors_all_evolve_and_give_to_each_other(make):
    parent = make.solution(agents=3, rules=40)
    child = child_of(make, parent, make.evaluation(0.5, (7, 7, 7), rules=40))
    copied = child.origin_kind == Origin.COPIED
    assert copied.any()
    assert not (child.origin_agent == np.arange(3)[:, None]).any()
    assert ((child.origin_kind == Origin.INITIAL).sum(axis=1) == 10).all()


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.integers(0, 4), min_size=2, max_size=5),
    st.floats(-1, 0.99),
    st.integers(0, 60),
    st.booleans(),
    st.integers(0, 2**32),
)
def test_what_holds_for_every_child(make, contribution, fitness, explorations, exchange, seed):
    rng, rules, agents = np.random.default_rng(seed), 9, len(contribution)
    parent = make.solution(agents=agents, rules=rules, seed=seed)
    evaluation = make.evaluation(fitness, contribution, rules=rules, rng=rng)
    child = child_of(make, parent, evaluation, explorations=explorations, exchange=exchange, seed=seed)
    np.testing.assert_array_equal(child.ids, rule_ids(child.rules.mask, child.rules.action))
    assert child.equals(child_of(make, parent, evaluation, explorations=explorations, exchange=exchange, seed=seed))
    kept = kept_count(rules, fitness, explorations, 100.0)
    low, used, error = low_quality(evaluation.contribution_sum), evaluation.used, evaluation.figures.error
    for agent in range(agents):
        fresh = child.origin_generation[agent] == 5
        if not low[agent]:
            assert not fresh.any()
            np.testing.assert_array_equal(child.ids[agent], parent.ids[agent])
            continue
        assert fresh.tolist() == [False] * kept + [True] * (rules - kept)
        order = sorted(range(rules), key=lambda rule, a=agent: (not used[a, rule], error[a, rule], rule))
        np.testing.assert_array_equal(child.ids[agent, :kept], parent.ids[agent, order[:kept]])
        donors = set(child.origin_agent[agent, child.origin_kind[agent] == Origin.COPIED].tolist())
        assert len(donors) <= 1
        assert all(contribution[donor] * agents >= sum(contribution) > 0 and donor != agent for donor in donors)
        assert exchange or not donors


def test_the_first_places_stay_and_give_nothing_to_the_rest(make):
    places, copied = 4, 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        parent = make.solution(agents=3, rules=12, seed=seed)
        evaluation = make.evaluation(0.9, (9, 0, 5), rules=12, rng=rng, usage=np.ones((3, 12)))
        child = offspring(
            parent, evaluation, explorations=0, generation=1, varrho=100.0, exchange=True, supply=make.supply(99),
            rng=rng, places=places,
        )  # fmt: skip
        np.testing.assert_array_equal(child.ids[:, :places], parent.ids[:, :places])
        figures = evaluation.figures
        kept = places + np.argsort(figures.error[1, places:])[:3]  # floor(8 * 0.45)
        np.testing.assert_array_equal(child.ids[1, places : places + 3], parent.ids[1, kept])
        taken = np.flatnonzero(child.origin_kind[1] == Origin.COPIED)
        if taken.size:
            donor = int(child.origin_agent[1, taken[0]])
            best = places + np.argsort(-figures.strength[donor, places:])[: taken.size]
            np.testing.assert_array_equal(child.ids[1, taken], parent.ids[donor, best])
        copied += taken.size
    assert copied > 30


def test_distinct_rules_are_new_to_their_agents(make):
    parent, evaluation = make.solution(agents=4, rules=90), make.evaluation(0.3, (0, 0, 1, 9), rules=90)
    main = load_grammar("main")

    def child(distinct: bool):
        return offspring(
            parent,
            evaluation,
            explorations=0,
            generation=1,
            varrho=100.0,
            exchange=True,
            supply=RuleSupply(lambda count, rng: random_rules(main, count, rng), np.random.SeedSequence(1)),
            rng=np.random.default_rng(0),
            distinct=distinct,
        )

    def doubles(made) -> int:
        fresh = (made.origin_generation == 1) & (made.origin_kind == Origin.RANDOM)
        rows = zip(made.ids.tolist(), fresh.tolist(), strict=True)
        return sum(ids.count(one) > 1 for ids, new in rows for one, is_new in zip(ids, new, strict=True) if is_new)

    assert doubles(child(False)) > 0
    assert doubles(child(True)) == 0
