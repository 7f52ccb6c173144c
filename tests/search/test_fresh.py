"""Children that have nothing of their parents but reflexes."""

from __future__ import annotations

import numpy as np

from slcs2_jax.search import Fresh
from slcs2_jax.search.reflexes import with_flags
from tests.search.test_knowledge import problem


def test_rules_are_new_and_reflexes_the_parents(make):
    known = problem(make, mode="reflex", search={"inherit_quality": True})
    supply, rng = known.supply(), np.random.default_rng(0)
    parent = with_flags(known.random_solution(supply, 0), rng.random((3, 10)) < 0.5)
    evaluation = make.evaluation(0.5, (1, 0, 0), rules=20, rng=rng)
    child = Fresh(known)(parent, evaluation, explorations=0, generation=4, members=(), supply=supply, rng=rng)
    known.check(child, 4)
    assert child.parent == 0
    np.testing.assert_array_equal(child.rules.reflex, parent.rules.reflex)
    assert not {*child.ids[:, 10:].ravel().tolist()} & {*parent.ids[:, 10:].ravel().tolist()}
    assert (child.rules.quality == 0).all()
