"""Dominated novelty: distances to those that are fitter decide who stays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slcs2_jax.config.registry import KINDS
from slcs2_jax.search.dominated_novelty import DominatedNovelty, dominated_novelty
from tests.search.test_map_elites import member


def test_by_hand():
    """Descriptors on a line; the fittest is beyond comparison, the others as far as their nearest fitter three."""
    fitness = np.array([0.9, 0.5, 0.7, 0.1, 0.6])
    place = np.array([[0.0], [0.4], [1.0], [0.5], [0.2]])
    found = dominated_novelty(fitness, place)
    assert found.tolist() == pytest.approx([math.inf, (0.2 + 0.4 + 0.6) / 3, 1.0, (0.1 + 0.3 + 0.5) / 3, 0.5])


def test_copies_do_not_keep_each_other():
    found = dominated_novelty(np.array([0.5, 0.5]), np.zeros((2, 1)))
    assert found.tolist() == [math.inf, 0.0]


def test_who_is_nearest_to_fitter_ones_leaves(make):
    assert KINDS["acceptance"].get("dominated_novelty") is DominatedNovelty
    kept = DominatedNovelty(make.problem(agents=2, population=2))
    arrivals = [(0.5, [4, 4]), (0.4, [4, 3]), (0.1, [4, 0]), (0.9, [4, 4])]
    verdicts = [kept.consider(member(make, f, g, c)) for g, (f, c) in enumerate(arrivals)]
    assert [verdict.accepted for verdict in verdicts] == [True, True, True, True]
    assert [verdict.removed for verdict in verdicts] == [(), (), (1,), (0,)]
    assert [one.generation for one in kept.members()] == [2, 3]
    refused = kept.consider(member(make, 0.2, 4, [4, 4]))
    assert (refused.accepted, refused.novelty, refused.size) == (False, 0.0, 2)


def test_it_goes_on_exactly(make):
    kept, other = (DominatedNovelty(make.problem(agents=2, population=2)) for _ in range(2))
    for generation, contribution in enumerate([[1, 1], [1, 0]]):
        kept.consider(member(make, 0.1, generation, contribution))
    other.restore(kept.members(), kept.state())
    newcomer = member(make, 0.05, 2, [3, 1])
    assert kept.consider(newcomer) == other.consider(newcomer)
    assert [one.generation for one in kept.members()] == [one.generation for one in other.members()]
