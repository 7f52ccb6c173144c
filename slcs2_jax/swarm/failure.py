"""Agents that fail and recover (model section 11). Off, there is nothing of this in a compiled program.

An agent that is down neither moves, sends, receives, beacons nor learns. Whether an agent works in a step is drawn
when the step before ends.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.world import randomness
from slcs2_jax.world.randomness import Purpose

CHANGEABLE = ("failure_rate", "failure_share", "recovery_steps")  # settings that may be traced


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class FailureParameters:
    """How agents fail.

    Attributes:
        rate: float32, chance of a working agent to fail in a step.
        recovery: float32, chance of a failed agent to work again in a step: its down time is geometric.
        times: int32 [K], steps in which `count` agents drawn at random fail, if they work.
        count: int32.
        keeps_packet: whether the packet that a failing agent holds stays with it; else it is lost.
    """

    rate: jax.Array
    recovery: jax.Array
    times: jax.Array
    count: jax.Array
    keeps_packet: bool = dataclasses.field(metadata={"static": True})

    @classmethod
    def of(cls, swarm: Any) -> FailureParameters | None:
        """Take the values from the settings, or anything with their attributes; None if nobody ever fails."""
        if not isinstance(swarm.failure_rate, jax.Array) and swarm.failure_rate == 0 and not swarm.failures_at:
            return None
        return cls(
            rate=jnp.float32(swarm.failure_rate),
            recovery=jnp.float32(0 if swarm.recovery_steps is None else 1 / swarm.recovery_steps),
            times=jnp.array(swarm.failures_at, jnp.int32),
            count=jnp.round(jnp.float32(swarm.failure_share * swarm.agents)).astype(jnp.int32),
            keeps_packet=swarm.failure_keeps_packet,
        )


def who_is_down(down: jax.Array, key: jax.Array, t: jax.Array, failures: FailureParameters) -> jax.Array:
    """Who is down in time-step t (int32 [...]), from who was in the one before: bool [n, ...]."""
    agent = np.arange(down.shape[0], dtype=np.uint32).reshape(-1, *(1,) * t.ndim)

    def words(purpose: Purpose) -> jax.Array:
        return randomness.bits(randomness.stream(key, t, purpose), agent)

    fails = randomness.uniform(words(Purpose.FAILURE)) < failures.rate
    recovers = randomness.uniform(words(Purpose.RECOVERY)) < failures.recovery
    due = jnp.any(failures.times.reshape(-1, *(1,) * t.ndim) == t, axis=0)
    lot = words(Purpose.FAILURE_LOT)
    before = (lot[:, None] < lot) | ((lot[:, None] == lot) & (agent[:, None] < agent))
    chosen = jnp.sum(before, axis=0, dtype=jnp.int32) < failures.count
    return jnp.where(down, ~recovers, fails) | (due & chosen)
