"""What became of each transmission, and what it was lost to (model section 3). Nothing depends on it."""

from __future__ import annotations

import enum

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.packets import Air, others
from slcs2_jax.world.radio import RadioParameters, decodable


class Fate(enum.IntEnum):
    """What became of a transmission. The first thing in this order that alone would have lost it counts."""

    NONE = 0  # nothing was sent
    DELIVERED = 1  # the packet changed hands
    WEAK = 2  # below P_rs, or drowned by thermal noise alone: distance, walls, shadowing
    JAMMED = 3  # the jammer alone sufficed
    INTERFERENCE = 4  # other transmissions, alone or together with the jammer
    REFUSED = 5  # received well enough by one that sends, holds a packet, or takes a stronger one


def fates(air: Air, links: Links, radio: RadioParameters) -> jax.Array:
    """The fate of every transmission at the receiver that it is meant for: uint8 [C, n + 1, n + 2, ...], of `Fate`."""
    jammer = links.jamming[:, None]
    interference = jax.vmap(others)(air.signal)
    reasons = [
        (air.accepted, Fate.DELIVERED),
        (~decodable(air.signal, jnp.float32(0), radio), Fate.WEAK),
        (~decodable(air.signal, jammer, radio), Fate.JAMMED),
        (~decodable(air.signal, jammer + interference, radio), Fate.INTERFERENCE),
    ]
    conditions = [~air.wanted, *(condition for condition, _ in reasons)]
    names = [np.uint8(Fate.NONE), *(np.uint8(fate) for _, fate in reasons)]
    return jnp.select(conditions, [jnp.full(air.wanted.shape, name) for name in names], np.uint8(Fate.REFUSED))
