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

    def in_two_passes(score: jax.Array) -> tuple[jax.Array, jax.Array]:
        best = jnp.min(score, axis=0)
        first = (score == best) & (score < jnp.inf)
        return jnp.min(jnp.where(first, rows(count, best), np.int32(count)), axis=0), best

    def in_one_pass(score: jax.Array) -> tuple[jax.Array, jax.Array]:
        index, best = first_of_least(score)
        return jnp.where(best < jnp.inf, index, np.int32(count)), best

    return jax.lax.platform_dependent(score, cpu=in_two_passes, default=in_one_pass)


def first_of_least(score: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The lowest index of the least score, int32 [n, ...], and that score; float32 [m, n, ...] -> float32 [n, ...].

    One pass over the scores; for GPUs, since CPUs lose their vector lanes over it.
    """

    def less(a: tuple[jax.Array, jax.Array], b: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        nearer = (a[1] < b[1]) | ((a[1] == b[1]) & (a[0] < b[0]))
        return jnp.where(nearer, a[0], b[0]), jnp.where(nearer, a[1], b[1])

    count = score.shape[0]
    index = jnp.broadcast_to(rows(count, score[0]), score.shape)
    return jax.lax.reduce((index, score), (np.int32(count), np.float32(np.inf)), less, (0,))


def take(table: jax.Array, index: jax.Array) -> jax.Array:
    """``table[index[i], i]`` for every agent i: float32 [m, n, ...] and int32 [n, ...] -> [n, ...]; 0 out of range."""
    return jnp.sum(jnp.where(rows(table.shape[0], index) == index, table, np.float32(0)), axis=0)


def rows(count: int, like: jax.Array) -> np.ndarray:
    """Numbers 0..count-1 along a new first axis before those of ``like``: int32 [count, 1...]."""
    return lift(np.arange(count, dtype=np.int32), like)
