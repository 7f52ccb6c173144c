"""A population of the fittest, and tournaments among its members."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slcs2_jax.search import Best, Tournament


def member(make, fitness: float, generation: int):
    return make.member(fitness, [[generation, 2]], generation)


def test_the_fittest_are_kept_and_of_equals_the_earlier(make):
    kept = Best(make.problem(population=2))
    verdicts = [kept.consider(member(make, f, g)) for g, f in enumerate([0.1, 0.3, 0.1, 0.2, -0.5, 0.4])]
    assert [verdict.accepted for verdict in verdicts] == [True, True, False, True, False, True]
    assert [verdict.removed for verdict in verdicts] == [(), (), (), (0,), (), (3,)]
    assert [verdict.size for verdict in verdicts] == [1, 2, 2, 2, 2, 2]
    assert [one.generation for one in kept.members()] == [1, 5]
    assert math.isnan(verdicts[0].novelty)
    assert verdicts[1].novelty == 0.5


def test_of_equals_the_newest_leaves(make):
    kept = Best(make.problem(population=2))
    for generation, fitness in enumerate([0.1, 0.1, 0.5]):
        kept.consider(member(make, fitness, generation))
    assert [one.generation for one in kept.members()] == [0, 2]


def test_it_goes_on_exactly(make):
    kept, other = (Best(make.problem(population=2)) for _ in range(2))
    for generation, fitness in enumerate([0.1, 0.3, 0.2]):
        kept.consider(member(make, fitness, generation))
    other.restore(kept.members(), kept.state())
    verdicts = [one.consider(member(make, 0.25, 3)) for one in (kept, other)]
    assert verdicts[0] == verdicts[1]
    assert [one.generation for one in kept.members()] == [one.generation for one in other.members()] == [1, 3]


@pytest.mark.parametrize("size", [1, 2, 4])
def test_a_tournament_takes_the_fittest_of_so_many(make, size):
    members = [member(make, fitness, place) for place, fitness in enumerate([0.0, 0.1, 0.2, 0.3])]
    choose, rng = Tournament(make.problem(tournament=size)), np.random.default_rng(0)
    drawn = np.bincount([choose(members, rng).generation for _ in range(2000)], minlength=4) / 2000
    expected = [((k + 1) / 4) ** size - (k / 4) ** size for k in range(4)]
    np.testing.assert_allclose(drawn, expected, atol=0.04)
