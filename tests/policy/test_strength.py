"""Strength against a plain list of all past action sets."""

from __future__ import annotations

import functools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.policy import bits, strength

RULES, AGENTS = 4, 2


@pytest.mark.parametrize(
    ("reward", "expected"),
    [(0, 0), (9, 1), (-9, -1), (99, 2), (0.5, math.log10(1.5)), (-0.05, -math.log10(1.05)), (700, math.log10(701))],
)
def test_gain_is_logarithmic_with_its_sign(reward, expected):
    got = strength.gain(jnp.float32([reward, reward]), jnp.array([True, False]))
    assert float(got[0]) == pytest.approx(expected, abs=1e-6)
    assert float(got[1]) == 0  # no action, nothing gained


@pytest.mark.parametrize("period", [1, 2, 7, 10, 12, 13, 30, 31, 64, 1000])
@pytest.mark.parametrize("bp_max", [0, 1, 5, 20, 24])
def test_rounds_divide_the_period_and_leave_room_for_the_trace(period, bp_max):
    length = strength.round_length(period, bp_max)
    assert period % length == 0
    assert 1 <= length <= 32 - bp_max
    assert not any(period % longer == 0 for longer in range(length + 1, min(period, 32 - bp_max) + 1))


@functools.partial(jax.jit, static_argnames="bp_max")
def simulate(members, gains, decay, bp_max):
    """Rounds of steps: members bool [rounds, L, R, n], gains float32 [rounds, L, n] -> after the last settlement."""

    def one_round(carry, given):
        total, usage, trace, recent = carry
        sets, gained = given
        packed = jnp.stack([bits.pack(one) for one in sets])
        total, usage, trace, recent = strength.settle(total, usage, trace, recent, packed, gained, decay)
        return (total, usage, trace, recent), None

    shape = members.shape[2:]
    start = (
        jnp.zeros(shape, jnp.float32),
        jnp.zeros(shape, jnp.int32),
        jnp.zeros(shape, jnp.uint32),
        jnp.zeros((bp_max, shape[-1]), jnp.float32),
    )
    total, usage, trace, recent = jax.lax.scan(one_round, start, (members, gains))[0]
    return total, usage, strength.finish(total, usage, trace, recent, decay)


def by_list(sets, gains, decay, bp_max):
    """Every step's gain added to each of the last bp_max + 1 action sets, model 6.5 word for word."""
    total, usage = np.zeros((RULES, AGENTS)), np.zeros((RULES, AGENTS), int)
    past = []
    for members, gain in zip(sets, gains, strict=True):
        past.append(members)
        usage += members
        for back, earlier in enumerate(reversed(past[-(bp_max + 1) :])):
            total += decay**back * gain * earlier
    return np.where(usage > 0, total / np.maximum(usage, 1), 0), usage


@pytest.mark.parametrize(
    ("bp_max", "period", "steps"),
    [(20, 10, 70), (0, 10, 30), (1, 7, 35), (5, 12, 60), (24, 8, 64), (24, 1, 40), (3, 28, 84)],
)
@pytest.mark.parametrize("decay", [0.8, 1.0, 0.0])
def test_against_a_list_of_past_action_sets(bp_max, period, steps, decay):
    rng = np.random.default_rng(bp_max * 100 + period)
    length = strength.round_length(period, bp_max)
    sets = rng.random((steps, RULES, AGENTS)) < np.array([0.6, 0.2, 0.02, 0.0])[:, None]
    gains = np.where(rng.random((steps, AGENTS)) < 0.8, rng.normal(0, 1, (steps, AGENTS)), 0).astype(np.float32)
    rounds = steps // length
    shaped = sets.reshape(rounds, length, RULES, AGENTS), gains.reshape(rounds, length, AGENTS)
    _, usage, final = simulate(*map(jnp.asarray, shaped), jnp.float32(decay), bp_max)
    expected, used = by_list(sets, gains.astype(float), decay, bp_max)
    np.testing.assert_array_equal(usage, used)
    np.testing.assert_allclose(final, expected, atol=2e-5)
    assert (np.asarray(final)[3] == 0).all()  # never used


def test_an_episode_that_ends_within_a_round_may_idle_through_the_rest():
    """Empty action sets and no gains after the end, for this round and two more, change nothing."""
    rng = np.random.default_rng(1)
    sets = np.zeros((50, RULES, AGENTS), bool)
    gains = np.zeros((50, AGENTS), np.float32)
    sets[:23], gains[:23] = rng.random((23, RULES, AGENTS)) < 0.4, rng.normal(0, 1, (23, AGENTS))
    expected, used = by_list(sets[:23], gains[:23].astype(float), 0.8, 20)
    for steps in (30, 50):
        shaped = sets[:steps].reshape(-1, 10, RULES, AGENTS), gains[:steps].reshape(-1, 10, AGENTS)
        _, usage, final = simulate(*map(jnp.asarray, shaped), jnp.float32(0.8), 20)
        np.testing.assert_array_equal(usage, used)
        np.testing.assert_allclose(final, expected, atol=1e-5)


def test_credit_by_hand():
    """One rule acts in step 0 only; the gains are 1, 2, 4; BP_max = 1 and lambda = 0.5: 1 + 0.5 * 2."""
    sets = np.zeros((3, 1, 1, 1), bool)
    sets[0] = True
    gains = np.float32([1, 2, 4]).reshape(3, 1, 1)
    _, usage, final = simulate(sets[:, None, 0], gains, jnp.float32(0.5), 1)
    assert usage.tolist() == [[1]]
    assert float(final[0, 0]) == pytest.approx(2)
