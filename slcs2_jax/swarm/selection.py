"""Choosing one of several candidates per agent without gathers, which vector hardware does badly."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm.state import lift
from slcs2_jax.world.stored import stored


def least(eligible: jax.Array | np.ndarray, score: jax.Array, witness: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The eligible candidate with the least score, the lowest index on ties.

    Args:
        eligible: bool [m, n, ...].
        score: float32 [m, n, ...], finite where eligible.
        witness: see ``stored``.

    Returns:
        index int32 [n, ...], m if none is eligible; its score float32 [n, ...], inf if none.
    """
    count = eligible.shape[0]
    score = stored(jnp.where(eligible, score, jnp.inf), witness)
    best = jnp.min(score, axis=0)
    first = (score == best) & (score < jnp.inf)
    index = jnp.min(jnp.where(first, rows(count, best), np.int32(count)), axis=0)
    return index, best


def take(table: jax.Array, index: jax.Array) -> jax.Array:
    """``table[index[i], i]`` for every agent i: float32 [m, n, ...] and int32 [n, ...] -> [n, ...]; 0 out of range."""
    return jnp.sum(jnp.where(rows(table.shape[0], index) == index, table, np.float32(0)), axis=0)


def rows(count: int, like: jax.Array) -> np.ndarray:
    """Numbers 0..count-1 along a new first axis before those of ``like``: int32 [count, 1...]."""
    return lift(np.arange(count, dtype=np.int32), like)
