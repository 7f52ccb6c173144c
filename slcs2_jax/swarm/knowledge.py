"""Knowledge K: last known positions, own and shared (model section 4)."""

from __future__ import annotations

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm import jamming
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.state import UNKNOWN, State, lift
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.radio import RadioParameters


def update(state: State, links: Links, arena: Arena, radio: RadioParameters) -> State:
    """Enter who is heard now, with place and time, and the jammer where its noise reaches P_rs."""
    n = state.x.shape[0]
    heard = links.heard[:n]
    state = dataclasses.replace(
        state,
        heard=links.heard,
        known_time=jnp.maximum(state.known_time, jnp.where(heard, state.t, UNKNOWN)),  # the fastest form of a choice
        known_x=jnp.where(heard, state.x[:, None], state.known_x),
        known_y=jnp.where(heard, state.y[:, None], state.known_y),
    )
    if links.jammers is not None:
        return jamming.notice(state, links.jammers, radio)
    noise = jnp.max(links.jamming[:, :n], axis=0)
    distance = jnp.sqrt((arena.jammer_x - state.x) ** 2 + (arena.jammer_y - state.y) ** 2)
    farthest = jnp.maximum(state.jammer_range, distance)
    return dataclasses.replace(state, jammer_range=jnp.where(noise >= radio.sensitivity, farthest, state.jammer_range))


def share(state: State) -> State:
    """Every agent merges what those whom it heard in the last step know; the newest time wins.

    What two agents know of a third at the same time is the same, so ties need no rule.
    """
    n = state.x.shape[0]
    heard = state.heard[:n]
    strangers = lift(~np.eye(n, dtype=bool), state.t)

    def news(table: tuple[jax.Array, ...]) -> tuple[jax.Array, ...]:
        """What each agent then knows of one other, from what all know of it: [n, ...] each."""
        time, x, y = table
        latest = jnp.max(jnp.where(heard, time[:, None], UNKNOWN), axis=0)
        source = heard & (time[:, None] == latest)
        told_x, told_y = (jnp.max(jnp.where(source, place[:, None], -jnp.inf), axis=0) for place in (x, y))
        newer = latest > time
        return jnp.where(newer, latest, time), jnp.where(newer, told_x, x), jnp.where(newer, told_y, y)

    # One other after another where tables are best kept in a cache, all at once where every start of a kernel counts.
    known = (state.known_time, state.known_x, state.known_y)
    time, x, y = jax.lax.platform_dependent(known, cpu=partial(jax.lax.map, news), default=jax.vmap(news))
    state = dataclasses.replace(
        state,
        known_time=jnp.where(strangers, time, state.known_time),
        known_x=jnp.where(strangers, x, state.known_x),
        known_y=jnp.where(strangers, y, state.known_y),
    )
    if state.jammers is not None:
        return jamming.share(state, heard)
    jammer = jnp.max(jnp.where(heard, state.jammer_range[:, None], np.float32(0)), axis=0)
    return dataclasses.replace(state, jammer_range=jnp.maximum(state.jammer_range, jammer))


def known(state: State) -> jax.Array:
    """Whether self knows of other: bool [n other, n self, ...]."""
    return state.known_time > UNKNOWN
