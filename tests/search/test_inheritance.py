"""What offspring start with: the quality that their rules had learnt."""

from __future__ import annotations

import dataclasses

import numpy as np

from slcs2_jax.grammar import RuleSets
from slcs2_jax.search import Exchange, Origin
from slcs2_jax.search.inheritance import learnt_quality, with_fresh


def test_used_rules_have_what_they_learnt_and_others_what_they_began_with(make):
    usage = np.array([[1, 0, 2], [0, 0, 5]])
    evaluation = make.evaluation(0.5, (1, 0), rules=3, usage=usage, quality=np.arange(6.0).reshape(2, 3))
    rules = make.solution(agents=2, rules=3).rules
    np.testing.assert_array_equal(learnt_quality(rules, evaluation, 7.0), [[0, 7, 2], [7, 7, 5]])
    began = dataclasses.replace(rules, quality=np.full((2, 3), -1, np.float32))
    np.testing.assert_array_equal(learnt_quality(began, evaluation, 7.0), [[0, -1, 2], [-1, -1, 5]])


def test_fresh_rules_have_the_greatest_of_their_rule_set():
    quality = np.array([[1, 9, -2], [4, 5, 6]], np.float32)
    parent = np.array([[0, 0, 0], [3, 8, 1]], np.float32)
    fresh = np.array([[False, True, False], [True, True, True]])
    np.testing.assert_array_equal(with_fresh(quality, fresh, parent), [[1, 1, -2], [8, 8, 8]])


def test_offspring_inherit_rule_by_rule(make):
    problem = make.problem(agents=4, rules=10, inherit_quality=True)
    parent = problem.random_solution(problem.supply(), 0)
    rng, copied, fresh = np.random.default_rng(3), 0, 0
    assert (parent.rules.quality == 0).all()
    for generation in range(1, 20):
        fields = {"usage": np.ones((4, 10)), "quality": rng.normal(size=(4, 10)).astype(np.float32)}
        evaluation = make.evaluation(0.9, (9, 0, 5, 0), rules=10, rng=rng, **fields)
        learnt = dict(zip(parent.ids.ravel().tolist(), fields["quality"].ravel().tolist(), strict=True))
        child = Exchange(problem)(
            parent, evaluation, explorations=0, generation=generation, members=(), supply=make.supply(generation),
            rng=rng,
        )  # fmt: skip
        new = child.origin_generation == generation
        random = new & (child.origin_kind == Origin.RANDOM)
        for place in np.argwhere(~random):
            assert child.rules.quality[tuple(place)] == np.float32(learnt[int(child.ids[tuple(place)])])
        for agent in np.flatnonzero(random.any(axis=1)):
            rest = child.rules.quality[agent][~random[agent]]
            assert (child.rules.quality[agent][random[agent]] == rest.max()).all()
        copied, fresh = copied + int((new & ~random).sum()), fresh + int(random.sum())
    assert min(copied, fresh) > 20


def test_without_the_setting_offspring_have_no_quality(make):
    problem = make.problem(agents=2, rules=4)
    parent = problem.random_solution(problem.supply(), 0)
    evaluation = make.evaluation(0.9, (1, 0))
    child = Exchange(problem)(
        parent, evaluation, explorations=0, generation=1, members=(), supply=make.supply(), rng=np.random.default_rng(0)
    )
    assert isinstance(child.rules, RuleSets)
    assert child.rules.quality is None
    assert child.rules.reflex is None
