"""Flags of reflexes change a little at a time."""

from __future__ import annotations

import numpy as np

from slcs2_jax.search.reflexes import mutate_flags, with_flags


def test_a_change_is_one_rule_in_the_swarm_or_in_few_or_the_flags_of_another():
    rng = np.random.default_rng(0)
    flags = rng.random((9, 6)) < 0.5
    whole = few = taken = 0
    for _ in range(600):
        before = flags.copy()
        changed = mutate_flags(flags, rng)
        np.testing.assert_array_equal(flags, before)
        agents, rules = np.nonzero(changed != flags)
        columns = {*rules.tolist()}
        alike = [np.array_equal(changed[agent], other) for agent in {*agents.tolist()} for other in flags]
        if len(columns) == 1 and (changed[:, rules[0]] == changed[0, rules[0]]).all():
            whole += 1
        elif len({*agents.tolist()}) == 1 and any(alike):
            taken += 1
        else:
            assert len(columns) == 1
            assert 1 <= len(agents) <= 3
            few += 1
    assert min(whole, few, taken) > 120


def test_a_switched_rule_becomes_what_it_was_not():
    rng, flags = np.random.default_rng(1), np.ones((1, 4), bool)
    for _ in range(20):
        assert (mutate_flags(flags, rng) != flags).sum() == 1
    flags = np.ones((5, 4), bool)
    counts = {int((~mutate_flags(flags, rng)).sum()) for _ in range(60)}
    assert counts == {1, 5}  # where all agents are alike there is nothing to take from another


def test_flags_are_of_the_first_rules_alone(make):
    flags = np.array([[True, False], [False, True]])
    solution = with_flags(make.solution(agents=2, rules=5), flags)
    np.testing.assert_array_equal(solution.rules.reflex[:, :2], flags)
    assert not solution.rules.reflex[:, 2:].any()
