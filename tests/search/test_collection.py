from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.config import InputError
from slcs2_jax.search import Collection, domination, novelty

A, B = [[1, 2]], [[3, 4]]  # nothing in common: distance 1
A2 = [[1, 5]]  # half of A: distance 0.5


def collection(make, omega0: float = 2.0) -> Collection:
    return Collection(make.problem(agents=1, rules=2, omega0=omega0))


def test_the_domination_effect():
    assert domination(0.5, 0.1, np.array(0.5), 0.6) == pytest.approx(0.1)
    assert domination(0.5, 0.5, np.array(0.0), 2.0) == 0  # its equal does not dominate


def test_omega_falls_with_the_size_before_the_newcomer(make):
    held = collection(make)
    assert held.omega == 2.0  # an empty collection counts as one
    for generation, ids in enumerate((A, B, [[6, 7]], [[8, 9]])):
        assert held.omega == 2.0 / max(1, generation)
        assert held.consider(make.member(0.0, ids, generation)).accepted


def test_the_first_newcomer_meets_nobody(make):
    verdict = collection(make).consider(make.member(-1.0, A, 0))
    assert (verdict.accepted, verdict.removed, verdict.size) == (True, (), 1)
    assert math.isnan(verdict.novelty)


@pytest.mark.parametrize(
    ("ids", "fitness", "accepted", "removed"),
    [
        # One member with fitness 0 and rules A, omega = 1: e(y, x) = 0 - f(x) - distance.
        (A, 0.0, True, ()),  # as fit and the same: neither dominates
        (A, -0.01, False, ()),
        (A, 0.01, True, (0,)),
        (A2, -0.5, True, ()),  # e(y, x) = 0.5 - 0.5 = 0
        (A2, -0.51, False, ()),
        (A2, 0.5, True, ()),
        (A2, 0.51, True, (0,)),
        (B, -1.0, True, ()),
        (B, 1.0, True, ()),
    ],
)
def test_entry_and_removal_against_one_member(make, ids, fitness, accepted, removed):
    held = collection(make, omega0=1.0)
    held.consider(make.member(0.0, A, 0))
    verdict = held.consider(make.member(fitness, ids, 1))
    assert (verdict.accepted, verdict.removed) == (accepted, removed)
    assert verdict.novelty == novelty(np.array(ids, np.uint64), np.array(A, np.uint64))
    assert [member.generation for member in held.members()] == [*({0} - set(removed)), *([1] if accepted else [])]
    assert verdict.size == len(held.members())


def test_a_refused_newcomer_removes_nobody(make):
    """e(0, x) > 0 refuses x, although x dominates the weaker, nearby member 1."""
    held = collection(make, omega0=1.0)
    held.consider(make.member(0.5, A, 0))
    held.consider(make.member(-0.4, [[1, 6]], 1))  # 0.5 + 0.4 - 0.5 > 0 would refuse it: so look first
    assert len(held.members()) == 1
    held.consider(make.member(-0.4, B, 1))
    assert len(held.members()) == 2
    verdict = held.consider(make.member(0.1, [[1, 4]], 2))  # omega 0.5: e(0, x) = 0.4 - 0.25; e(x, 1) = 0.5 - 0.25
    assert not verdict.accepted
    assert verdict.removed == ()
    assert len(held.members()) == 2


def test_removal_uses_the_omega_of_the_entry(make):
    """Two members, so omega = 1/2 for both rules; with 1 nobody would leave, with 1/3 both would."""
    held = collection(make, omega0=1.0)
    held.consider(make.member(0.0, A, 0))
    held.consider(make.member(0.1, B, 1))
    verdict = held.consider(make.member(0.55, [[8, 9]], 2))
    assert verdict.removed == (0,)  # 0.55 - 0.5 > 0; 0.45 - 0.5 < 0
    assert verdict.size == 2


def test_no_wild_omega(make):
    for omega0 in (-1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="omega0"):
            collection(make, omega0)


IDS = st.lists(st.integers(0, 5), min_size=2, max_size=2).map(lambda row: [row])


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.integers(-10, 10), IDS), min_size=1, max_size=15), st.sampled_from([0.0, 0.5, 2.0]))
def test_it_does_what_the_two_rules_say(make, newcomers, omega0):
    held, model = collection(make, omega0), []
    for generation, (tenths, ids) in enumerate(newcomers):
        fitness, rules = tenths / 10, np.array(ids, np.uint64)
        omega = omega0 / max(1, len(model))

        def effect(one, other, omega=omega):
            return one[1] - other[1] - omega * novelty(one[2], other[2])

        x = (generation, fitness, rules)
        if not any(effect(y, x) > 0 for y in model):
            model = [y for y in model if not effect(x, y) > 0] + [x]
        held.consider(make.member(fitness, ids, generation))
        assert [member.generation for member in held.members()] == [y[0] for y in model]
        best = max(value / 10 for value, _ in newcomers[: generation + 1])
        assert max(member.fitness for member in held.members()) == best  # the best never leaves
