"""Strength: each step's reward credited to the last BP_max + 1 action sets (paper, strength equation; model 6.5).

Instead of adding every reward to every past set, each rule keeps one bit per step, and each agent its last gains. A
set has all its credit BP_max steps later; then, a whole round at a time, the sum of its credits goes to its members.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.policy.bits import unpack
from slcs2_jax.world.stored import stored

HISTORY_BITS = 32


def gain(reward: jax.Array, acts: jax.Array) -> jax.Array:
    """log10(|rho| + 1) sgn(rho); 0 for agents that did not act: float32 [n, ...]."""
    size = jnp.log(jnp.abs(reward) + np.float32(1)) * np.float32(1 / np.log(10))
    return jnp.where(acts, size * jnp.sign(reward), np.float32(0))


def round_length(period: int, bp_max: int) -> int:
    """Steps between settlements: the longest divisor of the period whose bits still fit beside BP_max older ones."""
    return next(steps for steps in range(min(period, HISTORY_BITS - bp_max), 0, -1) if period % steps == 0)


def settle(
    strength: jax.Array,
    usage: jax.Array,
    trace: jax.Array,
    recent: jax.Array,
    sets: jax.Array,
    gains: jax.Array,
    decay: jax.Array,
) -> tuple[jax.Array, jax.Array, jax.Array, jax.Array]:
    """After a round of L steps: credit the sets that became BP_max steps old in it, and count the new ones' members.

    Args:
        strength: float32 [R, n, ...].
        usage: int32 [R, n, ...], tau.
        trace: uint32 [R, n, ...], bit k tells whether the rule was in the action set k steps ago, before the round.
        recent: float32 [BP_max, n, ...], gains of the steps before the round, the latest first.
        sets: uint32 [L, W, n, ...], action sets of the round as `bits`, the latest last.
        gains: float32 [L, n, ...], gains of the round, the latest last.
        decay: float32 scalar, lambda.

    Returns:
        strength, usage, trace and recent for the next round.
    """
    length, depth = gains.shape[0], recent.shape[0]
    latest_first = jnp.concatenate([gains[::-1], recent])
    credit = _credit(latest_first, decay, depth + 1, range(depth, depth + length))
    for members in sets:
        trace = (trace << np.uint32(1)) | unpack(members, trace.shape[0]).astype(jnp.uint32)
    strength = _pay(strength, trace, stored(credit, decay), range(depth, depth + length))
    fresh = trace & np.uint32((1 << length) - 1)
    return strength, usage + jax.lax.population_count(fresh).astype(jnp.int32), trace, latest_first[:depth]


def finish(strength: jax.Array, usage: jax.Array, trace: jax.Array, recent: jax.Array, decay: jax.Array) -> jax.Array:
    """At the end: credit the sets that are not BP_max steps old, and divide by usage; 0 for rules never used."""
    depth = recent.shape[0]
    credit = _credit(recent, decay, depth + 1, range(depth))
    total = _pay(strength, trace, credit, range(depth))
    return jnp.where(usage > 0, total / jnp.maximum(usage, 1).astype(jnp.float32), np.float32(0))


def _credit(latest_first: jax.Array, decay: jax.Array, reach: int, ages: range) -> list[jax.Array]:
    """For each age k the sum over t' < reach, t' <= k, of lambda^t' times the gain k - t' steps ago."""
    weights = [decay**j for j in range(reach)]
    return [sum(weights[j] * latest_first[k - j] for j in range(min(k + 1, reach))) for k in ages]  # type: ignore[misc]


def _pay(strength: jax.Array, trace: jax.Array, credit: list[jax.Array], ages: range) -> jax.Array:
    for amount, age in zip(credit, ages, strict=True):
        member = (trace >> np.uint32(age)) & np.uint32(1)
        strength = strength + member.astype(jnp.float32) * amount
    return strength
