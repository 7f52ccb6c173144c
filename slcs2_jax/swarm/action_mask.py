"""Which actions could have an effect now."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.language import Language
from slcs2_jax.swarm.intent import interpret
from slcs2_jax.swarm.view import View


def action_mask(view: View, actions: tuple[int, ...], language: Language) -> jax.Array:
    """A move needs a target that is defined, a send a packet and a receiver, a collect the source in reach and room.

    Args:
        view: what there is to see.
        actions: A numbers of the vocabulary.
        language: what can be said and done.

    Returns:
        bool [A, n, ...]; False throughout for who is down, and once the episode is over.
    """
    n, state = view.x.shape[0], view.state
    numbers = np.array(actions, np.int32).reshape(-1, *(1,) * view.x.ndim)
    everybody = jnp.broadcast_to(numbers, (len(actions), *view.x.shape))
    meant = jax.vmap(partial(interpret, view=view, language=language))(everybody)
    collects = view.heard[n] & ~state.holding & (state.waiting > 0)
    sends = state.holding & (meant.node < n + 2)
    useful = jnp.where(meant.moves, meant.place_known, jnp.where(meant.collects, collects, sends))
    return useful & view.able
