"""MAP-Elites as an acceptance: the fittest of each niche, over how the work is shared."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config.registry import KINDS
from slcs2_jax.search.map_elites import MapElites, niche_of
from slcs2_jax.search.member import Member
from slcs2_jax.search.parents import Uniform


def member(make, fitness: float, generation: int, contribution):
    made = make.member(fitness, [[generation, 2]] * len(contribution), generation)
    evaluation = dataclasses.replace(made.evaluation, contribution_sum=np.array(contribution, np.int64))
    return Member(made.solution, evaluation)


def test_they_are_there_by_name():
    assert KINDS["acceptance"].get("map_elites") is MapElites
    assert KINDS["parent"].get("uniform") is Uniform


@pytest.mark.parametrize(
    ("contribution", "niche"),
    [([0, 0, 0, 0], (0, 0)), ([8, 0, 0, 0], (2, 2)), ([8, 8, 8, 8], (9, 9)), ([8, 4, 0, 0], (5, 3))],
)
def test_niches_are_who_takes_part_and_how_evenly(make, contribution, niche):
    assert niche_of(member(make, 0.1, 0, contribution)) == niche


def test_a_newcomer_takes_an_empty_niche_or_one_that_is_held_by_less(make):
    kept = MapElites(make.problem(agents=2))
    arrivals = [(0.5, [4, 4]), (0.1, [4, 0]), (0.4, [3, 3]), (0.5, [5, 5]), (0.6, [2, 2])]
    verdicts = [kept.consider(member(make, f, g, c)) for g, (f, c) in enumerate(arrivals)]
    assert [verdict.accepted for verdict in verdicts] == [True, True, False, False, True]
    assert [verdict.removed for verdict in verdicts] == [(), (), (), (), (0,)]
    assert [one.generation for one in kept.members()] == [1, 4]


def test_it_goes_on_exactly(make):
    kept, other = (MapElites(make.problem(agents=2)) for _ in range(2))
    for generation, contribution in enumerate([[1, 1], [1, 0]]):
        kept.consider(member(make, 0.1, generation, contribution))
    other.restore(kept.members(), kept.state())
    newcomer = member(make, 0.2, 2, [3, 0])
    assert repr(kept.consider(newcomer)) == repr(other.consider(newcomer))  # NaN is not equal to itself
    assert [one.generation for one in kept.members()] == [one.generation for one in other.members()] == [0, 2]


def test_any_member_may_be_a_parent(make):
    members = [member(make, 0.1 * place, place, [1, 1]) for place in range(4)]
    choose, rng = Uniform(make.problem(agents=2)), np.random.default_rng(0)
    drawn = np.bincount([choose(members, rng).generation for _ in range(2000)], minlength=4) / 2000
    assert drawn.tolist() == pytest.approx([0.25] * 4, abs=0.03)
