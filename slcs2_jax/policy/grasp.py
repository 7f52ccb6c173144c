"""GRASP: a rule drawn uniformly from the restricted candidate list (paper, GRASP equation; model section 6.2)."""

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

    Every rule of the list draws a ticket whose low bits carry the action, so that one maximum both draws the rule and
    tells what it does.

    Args:
        match: bool [R, n, ...].
        quality: float32 [R, n, ...].
        action: uint8 [R, n, ...].
        lots: uint32 [R, n, ...], uniform words.
        alpha_grasp: float32 scalar.

    Returns:
        int32 [n, ...], a number of the vocabulary; ``NO_ACTION`` where nothing matches.
    """
    tickets, found = _tickets(match, quality, action, lots, alpha_grasp)
    winner = jnp.max(tickets, axis=0)
    return jnp.where(found, (winner & ACTION_BITS).astype(jnp.int32), np.int32(NO_ACTION))


def chosen(
    match: jax.Array, quality: jax.Array, action: jax.Array, lots: jax.Array, alpha_grasp: jax.Array
) -> jax.Array:
    """The rule whose action ``choose`` returns for the same arguments: int32 [n, ...]; -1 where nothing matches."""
    tickets, found = _tickets(match, quality, action, lots, alpha_grasp)
    return jnp.where(found, jnp.argmax(tickets, axis=0).astype(jnp.int32), np.int32(-1))


def _tickets(
    match: jax.Array, quality: jax.Array, action: jax.Array, lots: jax.Array, alpha_grasp: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Tickets of the restricted candidate list, 0 for other rules, uint32 [R, n, ...]; is there any, bool [n, ...]."""
    best = jnp.max(jnp.where(match, quality, -jnp.inf), axis=0)
    worst = jnp.min(jnp.where(match, quality, jnp.inf), axis=0)
    found = best > -jnp.inf
    spread = jnp.where(found, best - worst, np.float32(0))
    listed = match & (best - quality <= alpha_grasp * spread)
    ticket = (lots & ~ACTION_BITS) | action.astype(jnp.uint32)
    return jnp.where(listed, ticket, np.uint32(0)), found
