"""When, and on which channel, a jammer transmits (model sections 3 and 11).

An emission is a function of what all jammers of a world hear and are set to; a user's own is registered as
`register("emission", name)`. It is asked for all J jammers at once, and told apart afterwards whose answer counts.
Constant, random and reactive jammers are those of Xu, Trappe, Zhang and Wood, The feasibility of launching and
detecting jamming attacks in wireless networks, MobiHoc 2005, section 3.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.world.randomness import mix, uniform

SILENT = np.int32(-1)


@dataclasses.dataclass(frozen=True)
class Listening:
    """What an emission may depend on. J jammers, C channels.

    Attributes:
        t: int32 [...], the time-step.
        number: int32 [J, 1...], 0 to J - 1.
        hears: bool [J, ...], whether anything reaches the jammer at P_rs or more. In every step all beacons go out on
            every channel in use.
        channels: bool [C, ...], the channels in use.
        duty: float32 [J, ...], share of the time.
        dwell: int32 [J, ...], steps.
        words: of times int32 [J, ...] uniform words, uint32 [J, ...]; the same for the same jammer and time.
    """

    t: jax.Array
    number: np.ndarray
    hears: jax.Array
    channels: jax.Array
    duty: jax.Array
    dwell: jax.Array
    words: Callable[[jax.Array], jax.Array]


def reactive(listening: Listening) -> jax.Array:
    """The paper's: on the first channel on which it receives anything, within the same step: int32 [J, ...]."""
    return jnp.where(listening.hears, in_use(listening.channels, jnp.zeros_like(listening.dwell)), SILENT)


def constant(listening: Listening) -> jax.Array:
    """Always, on the first channel in use: int32 [J, ...]."""
    return in_use(listening.channels, jnp.zeros_like(listening.dwell))


def random(listening: Listening) -> jax.Array:
    """In intervals of `dwell` steps, each with chance `duty`, on a channel in use drawn for it: int32 [J, ...]."""
    word = listening.words(listening.t // listening.dwell)
    lot = (mix(word) >> np.uint32(8)).astype(jnp.int32)
    return jnp.where(uniform(word) < listening.duty, in_use(listening.channels, lot), SILENT)


def sweeping(listening: Listening) -> jax.Array:
    """Always, on one channel in use after another, each for `dwell` steps: int32 [J, ...].

    The next jammer is always one channel ahead, so that several sweep side by side.
    """
    return in_use(listening.channels, listening.t // listening.dwell + listening.number)


def in_use(channels: jax.Array, number: jax.Array) -> jax.Array:
    """The channel in use with a number among those in use, modulo how many there are: int32 [J, ...]."""
    count = jnp.maximum(jnp.sum(channels, axis=0, dtype=jnp.int32), np.int32(1))
    number = number % count
    before, found = jnp.zeros_like(count), jnp.full_like(number, SILENT)
    for channel in range(channels.shape[0]):
        used = channels[channel]
        found = jnp.where(used & (before == number), np.int32(channel), found)
        before = before + used.astype(jnp.int32)
    return found
