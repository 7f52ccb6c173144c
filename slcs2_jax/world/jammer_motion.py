"""How a jammer moves (model section 11). It flies: nothing stops it, and its places are no obstacle.

A motion is a function of where all jammers of a world are and what they hear; a user's own is registered as
`register("jammer motion", name)`. It is asked for all J jammers at once, and told apart afterwards whose answer counts.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

Places = tuple[jax.Array, jax.Array]


@dataclasses.dataclass(frozen=True)
class Wandering:
    """What a motion may depend on. J jammers, P points of a route; places in m.

    Attributes:
        t: int32 [...], the time-step that ends.
        x, y: float32 [J, ...], where the jammer is.
        route_x, route_y: float32 [P, J, ...], its points, of which the first is where it starts; what is more than a
            jammer has repeats the first.
        speed: float32 [J, ...], m per step.
        hears: bool [J, ...], whether anything reaches it at P_rs or more.
        heard_x, heard_y: float32 [J, ...], where the strongest of that comes from.
    """

    t: jax.Array
    x: jax.Array
    y: jax.Array
    route_x: jax.Array
    route_y: jax.Array
    speed: jax.Array
    hears: jax.Array
    heard_x: jax.Array
    heard_y: jax.Array


def fixed(wandering: Wandering) -> Places:
    """The paper's: it stays: float32 [J, ...] twice."""
    return wandering.x, wandering.y


def patrol(wandering: Wandering) -> Places:
    """Round and round from point to point and back to the first: float32 [J, ...] twice.

    A function of the time alone: after t steps it is t * speed along the closed way.
    """
    x, y = wandering.route_x, wandering.route_y
    step_x, step_y = jnp.roll(x, -1, axis=0) - x, jnp.roll(y, -1, axis=0) - y
    lengths = jnp.sqrt(step_x * step_x + step_y * step_y)
    way = jnp.maximum(jnp.sum(lengths, axis=0), np.float32(1e-6))
    gone = wandering.speed * (wandering.t + np.int32(1)).astype(jnp.float32)
    gone = gone - jnp.floor(gone / way) * way
    at_x, at_y = x[0], y[0]
    start = jnp.zeros_like(way)
    for leg in range(x.shape[0]):
        share = (gone - start) / jnp.maximum(lengths[leg], np.float32(1e-6))
        here = (share >= 0) & (share < 1) & (lengths[leg] > 0)
        at_x = jnp.where(here, x[leg] + share * step_x[leg], at_x)
        at_y = jnp.where(here, y[leg] + share * step_y[leg], at_y)
        start = start + lengths[leg]
    return at_x, at_y


def pursue(wandering: Wandering) -> Places:
    """Straight toward whoever is received strongest, agent or node; it stays while it hears nobody."""
    dx, dy = wandering.heard_x - wandering.x, wandering.heard_y - wandering.y
    distance = jnp.sqrt(dx * dx + dy * dy)
    moves = wandering.hears & (distance > 0)
    share = jnp.minimum(wandering.speed, distance) / jnp.where(moves, distance, np.float32(1))
    share = jnp.where(moves, share, np.float32(0))
    return wandering.x + share * dx, wandering.y + share * dy
