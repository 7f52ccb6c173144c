"""Swarms of one rule-set: what is pooled, what contribution and exchange mean, and that nothing else comes out."""

from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.search import Origin, RandomSearch, Slcs2
from slcs2_jax.search.homogeneous import for_all, pooled, shared_rules
from slcs2_jax.search.offspring import donor_weights, low_quality


def test_figures_are_means_weighted_with_usage(make):
    usage = np.array([[1, 0, 0, 2], [3, 0, 4, 2]])
    strength = np.array([[4.0, 9.0, 9.0, 1.0], [8.0, 9.0, 2.0, 3.0]])
    evaluation = make.evaluation(0.5, (3, 4), usage=usage, strength=strength, error=strength, quality=-strength)
    figures = pooled(evaluation).figures
    np.testing.assert_array_equal(figures.strength, [[7.0, 0.0, 2.0, 2.0]])
    np.testing.assert_array_equal(figures.error, figures.strength)
    np.testing.assert_array_equal(figures.quality, -figures.strength)
    np.testing.assert_array_equal(figures.usage, [[2.0, 0.0, 2.0, 2.0]])
    assert {array.dtype for array in figures.arrays().values()} == {np.dtype(np.float32)}


def test_contribution_is_the_sum_and_the_rule_set_always_evolves_without_a_donor(make):
    for contribution in ((3, 4), (0, 0), (7, 0)):
        total = pooled(make.evaluation(0.5, contribution)).contribution_sum
        assert total.tolist() == [sum(contribution)]
        assert low_quality(total).tolist() == [True]
        assert not donor_weights(total, np.array([0])).any()


def test_one_rule_set_and_back(make):
    swarm = for_all(make.solution(agents=1, rules=5), 4)
    assert swarm.shape == (4, 5)
    assert swarm.homogeneous
    assert for_all(shared_rules(swarm), 4).equals(swarm)
    assert not make.solution(agents=2, rules=5).homogeneous


@pytest.mark.parametrize("kind", [Slcs2, RandomSearch])
def test_all_agents_have_the_same_rules_in_every_generation(make, kind):
    search = make.search(kind=kind, agents=4, rules=10, homogeneous=True, generations=12)
    rng = np.random.default_rng(0)
    for generation in range(12):
        [solution] = search.ask()
        search.problem.check(solution, generation)
        assert solution.homogeneous
        assert not (solution.origin_kind == Origin.COPIED).any()
        search.tell([solution], [make.evaluation(0.8, (5, 0, 1, 2), rules=10, rng=rng)])


def test_exchange_changes_nothing(make):
    children = []
    for exchange in (True, False):
        search = make.search(agents=4, rules=10, homogeneous=True, exchange=exchange)
        search.tell(search.ask(), [make.evaluation(0.8, (5, 0, 1, 2), rules=10, rng=np.random.default_rng(1))])
        children += search.ask()
    assert children[0].equals(children[1])


def test_the_rules_kept_are_those_of_lowest_pooled_error(make):
    search = make.search(agents=2, rules=4, homogeneous=True)
    [parent] = search.ask()
    error = np.array([[0.9, 0.1, 0.0, 0.3], [0.0, 0.1, 0.5, 0.3]])
    usage = np.array([[9, 1, 0, 1], [1, 1, 1, 1]])  # pooled errors: 0.81, 0.1, 0.5, 0.3
    search.tell([parent], [make.evaluation(0.999, (5, 1), rules=4, error=error, usage=usage)])
    [child] = search.ask()
    assert (child.origin_generation == [[0, 1, 1, 1]] * 2).all()  # floor(4 * 0.4995) = 1 is kept
    np.testing.assert_array_equal(child.ids[:, 0], parent.ids[:, 1])


def test_a_search_that_gives_agents_different_rules_is_refused(make):
    problem = make.problem(agents=2, rules=4, homogeneous=True, name="random")
    with pytest.raises(InputError, match=r"search=random: the solution of generation 0 has different rule-sets"):
        problem.check(make.solution(agents=2, rules=4), 0)
