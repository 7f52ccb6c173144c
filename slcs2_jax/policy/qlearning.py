"""Q-learning over the action set, one step late, and the prediction error (paper, their equations; model 6.4)."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import optax


def best_ahead(quality: jax.Array, match: jax.Array) -> jax.Array:
    """The greatest quality in the match set, 0 if it is empty: float32 [n, ...].

    Args:
        quality: float32 [R, n, ...].
        match: bool [R, n, ...].
    """
    best = jnp.max(jnp.where(match, quality, -jnp.inf), axis=0)
    return jnp.where(best > -jnp.inf, best, np.float32(0))


def update(
    quality: jax.Array,
    error: jax.Array,
    members: jax.Array,
    reward: jax.Array,
    ahead: jax.Array,
    alpha: jax.Array,
    beta: jax.Array,
) -> tuple[jax.Array, jax.Array]:
    """Learn from the last action once the next match set is known.

    q <- (1 - alpha) q + alpha (rho + beta max q over the next match set);
    error <- (1 - alpha) error + alpha |rho - q|, q before the update.

    Args:
        quality, error: float32 [R, n, ...].
        members: bool [R, n, ...], the last action set.
        reward: float32 [n, ...], rho of the last action.
        ahead: float32 [n, ...], the greatest quality in the next match set.
        alpha: float32 [...], the learning rate of the last step.
        beta: float32 scalar, discount.

    Returns:
        The new quality and error.
    """
    target = reward + beta * ahead
    learnt = optax.incremental_update(jnp.broadcast_to(target, quality.shape), quality, alpha)
    missed = optax.incremental_update(jnp.abs(reward - quality), error, alpha)
    return jnp.where(members, learnt, quality), jnp.where(members, missed, error)
