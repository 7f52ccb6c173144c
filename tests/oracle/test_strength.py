"""Strength against a plain list of past action sets."""

import math

import numpy as np
import pytest

from tests.oracle import memory, model, strength
from tests.oracle.episode import step


@pytest.mark.parametrize(("reward", "credit"), [(0.0, 0.0), (9.0, 1.0), (-9.0, -1.0), (99.0, 2.0)])
def test_credit(reward, credit):
    assert strength.credit_of(reward) == pytest.approx(credit)


def play_sets(rng, steps, length, rules=12):
    """Random action sets (some empty) and credits; the strength by the module and by the list of all sets."""
    past_set = np.zeros((length, rules), np.uint16)
    past_size, past_credit = np.zeros(length, np.int64), np.zeros(length)
    by_module, by_list, sets = np.zeros(rules), np.zeros(rules), []
    for t in range(steps):
        if t >= length:
            strength.retire(t, past_set, past_size, past_credit, 0.8, by_module)
        members = rng.choice(rules, rng.integers(0, 4), replace=False)
        credit = rng.normal() if len(members) else 0.0
        now = t % length
        past_set[now, : len(members)] = members
        past_size[now], past_credit[now] = len(members), credit
        sets.append(members)
        for age, past in enumerate(reversed(sets[-length:])):
            by_list[past] += 0.8**age * credit
    strength.settle(steps, past_set, past_size, past_credit, 0.8, by_module)
    return by_module, by_list


@pytest.mark.parametrize("length", [1, 2, 21])
@pytest.mark.parametrize("steps", [0, 1, 20, 21, 22, 100])
def test_strength_equals_the_list_of_past_sets(length, steps):
    by_module, by_list = play_sets(np.random.default_rng(steps), steps, length)
    np.testing.assert_allclose(by_module, by_list, atol=1e-12)


def test_history_and_strength_can_be_taken_out_and_put_back(make, params):
    rules, world = make.rules(3), make.world(3)
    state, work = model.new_state(world, rules, params), model.new_work(world, rules)
    rewards = np.zeros((4, params.bp_max + 1))
    for t in range(30):
        step(state, world, rules, params, 5, 6, t, work)
        rewards = np.roll(rewards, 1, axis=1)
        rewards[:, 0] = state.reward
    copy = model.new_state(world, rules, params)
    memory.restore_history(copy, 30, memory.set_history(state, 30), rewards)
    memory.restore_strength(copy, params, 30, memory.credited_strength(state, params, 30))
    np.testing.assert_array_equal(copy.past_size, state.past_size)
    np.testing.assert_allclose(copy.past_credit, state.past_credit)
    np.testing.assert_allclose(copy.strength, state.strength, atol=1e-12)
    np.testing.assert_array_equal(memory.set_history(copy, 30), memory.set_history(state, 30))
    assert math.isclose(copy.reward.sum(), state.reward.sum())
