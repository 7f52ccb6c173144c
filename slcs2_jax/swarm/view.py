"""What there is to see in a time-step, as every part that looks on is given it: clauses, actions, policies, tasks."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.roles import Candidates
from slcs2_jax.swarm.state import State, SwarmParameters
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.radio import RadioParameters


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class View:
    """A time-step after everybody has listened, before anybody acts. n agents; the batch, if any, is the last axis.

    Attributes:
        state: of the swarm; places, packets, what is known.
        arena: the world.
        links: received powers and who hears whom.
        everybody: K and the nodes, with places and distances.
        left: five float32 [n, ...], m, distances to so, si, c, sink and source; inf if undefined.
        right: six float32 [n, ...], m, so, si, c, d_th, net and the jammer's range; inf if undefined.
        node_heard: bool [n, ...], source or sink is in N.
        running: bool [...], False once the episode is over.
        radio, swarm: the physical parameters.
    """

    state: State
    arena: Arena
    links: Links
    everybody: Candidates
    left: tuple[jax.Array, ...]
    right: tuple[jax.Array, ...]
    node_heard: jax.Array
    running: jax.Array
    radio: RadioParameters
    swarm: SwarmParameters

    @property
    def able(self) -> jax.Array:
        """Who can act: nobody once the episode is over, and nobody who is down: bool [...] or [n, ...]."""
        return self.running if self.state.down is None else self.running & ~self.state.down

    @property
    def x(self) -> jax.Array:
        """The agents' places along the line from source to sink: float32 [n, ...], m."""
        return self.state.x

    @property
    def y(self) -> jax.Array:
        """The agents' places across that line: float32 [n, ...], m."""
        return self.state.y

    @property
    def holding(self) -> jax.Array:
        """Who has a packet: bool [n, ...]."""
        return self.state.holding

    @property
    def heard(self) -> jax.Array:
        """N: bool [n + 2, n, ...], whose beacons self decoded; agents, source, sink."""
        return self.links.heard


def checked(kind: str, name: str, value: Any, like: jax.Array, dtype: Any) -> jax.Array:
    """What a user's part returned, if it is of this type and can be spread to the shape of `like`.

    Raises InputError naming the part, what it returned, and what is accepted.
    """
    found, shape = getattr(value, "dtype", None), getattr(value, "shape", ())
    try:
        fits = found == np.dtype(dtype) and np.broadcast_shapes(shape, like.shape) == like.shape
    except ValueError:
        fits = False
    if not fits:
        told = type(value).__name__ if found is None else f"{found}{list(shape)}"
        raise InputError(f"{kind} {name!r}: returned {told}; accepted is {np.dtype(dtype)}{list(like.shape)}")
    return jax.numpy.broadcast_to(value, like.shape)
