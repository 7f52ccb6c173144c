"""GRASP: a rule drawn uniformly from the restricted candidate list (paper, GRASP equation; spec section 6.2)."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.vocabulary import NO_ACTION

ACTION_BITS = np.uint32(0xFF)


def choose(
    match: jax.Array, quality: jax.Array, action: jax.Array, lots: jax.Array, alpha_grasp: jax.Array
) -> jax.Array:
    """The action of one rule of the match set with q >= q_max - alpha_grasp (q_max - q_min).

    Every rule draws a lot; the greatest of the list wins. The lot's low bits carry the action, so that one maximum both
    draws the rule and tells what it does.

    Args:
        match: bool [R, n, ...].
        quality: float32 [R, n, ...].
        action: uint8 [R, n, ...].
        lots: uint32 [R, n, ...], uniform words.
        alpha_grasp: float32 scalar.

    Returns:
        int32 [n, ...], a number of the vocabulary; ``NO_ACTION`` where nothing matches.
    """
    best = jnp.max(jnp.where(match, quality, -jnp.inf), axis=0)
    worst = jnp.min(jnp.where(match, quality, jnp.inf), axis=0)
    found = best > -jnp.inf
    spread = jnp.where(found, best - worst, np.float32(0))
    listed = match & (best - quality <= alpha_grasp * spread)
    ticket = (lots & ~ACTION_BITS) | action.astype(jnp.uint32)
    winner = jnp.max(jnp.where(listed, ticket, np.uint32(0)), axis=0)
    return jnp.where(found, (winner & ACTION_BITS).astype(jnp.int32), np.int32(NO_ACTION))
