"""Jammers where they are more than the paper's one: their links, what they do, what agents know of them (model 11).

The first of J jammers is the last node of the table of links, as the paper's is; the others have tables of their own.
A link of jammer j >= 1 is named by j, whatever else there is, so that no draw depends on the room of a batch.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm.selection import least, take
from slcs2_jax.swarm.state import UNKNOWN, JammerState, State, lift
from slcs2_jax.world import randomness
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.emission import SILENT, Listening
from slcs2_jax.world.emitters import Emitters, moved, transmits_on
from slcs2_jax.world.geometry import count_crossings
from slcs2_jax.world.jammer_motion import Wandering
from slcs2_jax.world.radio import RadioParameters, received_power
from slcs2_jax.world.randomness import Purpose

NODES = 128  # more than any world has: how far the names of two jammers' links are apart
WORDS = 1 << 16  # more than all names of links: how far the names of two words of a link are apart


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Jamming:
    """What the J jammers do in a step.

    Attributes:
        channel: int32 [J, ...], index of the channel that each transmits on; -1 for none.
        noise: float32 [J, n + 2, ...], mW received from each; 0 from one that is silent.
    """

    channel: jax.Array
    noise: jax.Array


def draw(state: State, arena: Arena, radio: RadioParameters) -> jax.Array:
    """The links of the second jammer and further ones, to agents, source and sink: float32 [J - 1, n + 2, ...], mW."""
    assert state.jammers is not None
    nodes = state.node_x.shape[0] - 1
    x, node_x = jnp.broadcast_arrays(state.jammers.x[:, None], state.node_x[:nodes])
    y, node_y = jnp.broadcast_arrays(state.jammers.y[:, None], state.node_y[:nodes])
    number = np.arange(1, x.shape[0] + 1)[:, None] * NODES + np.arange(nodes)
    stream = randomness.stream(state.key, state.t, Purpose.JAMMER_LINK)

    def words(k: int) -> jax.Array:
        return randomness.bits(stream, lift((number + k * WORDS).astype(np.uint32), state.t))

    squared = (node_x - x) ** 2 + (node_y - y) ** 2
    walls = count_crossings(x, y, node_x, node_y, arena.walls)
    return received_power(squared, walls, radio.fading.gain(words), radio)


def answer(received: jax.Array, up: jax.Array | None, state: State, arena: Arena, radio: RadioParameters) -> Jamming:
    """What every jammer transmits, and what of it arrives.

    Args:
        received: float32 [n + 2, ...], mW between the nodes and the first jammer.
        up: bool [n + 2, ...], which nodes work; None if all do.
        state, arena, radio: of the step.
    """
    emitters, power = _powers(received, state, arena)
    audible = power if up is None else jnp.where(up, power, np.float32(0))
    number = lift(np.arange(power.shape[0], dtype=np.int32), state.t)

    def words(time: jax.Array) -> jax.Array:
        stream = randomness.stream(state.key, time, Purpose.EMISSION)
        return randomness.bits(stream, number.astype(np.uint32))

    channel = transmits_on(
        emitters,
        Listening(
            t=state.t,
            number=number,
            hears=jnp.any(audible >= radio.sensitivity, axis=1),
            channels=arena.channels,
            duty=emitters.duty,
            dwell=emitters.dwell,
            words=words,
        ),
    )
    silent = (channel == SILENT)[:, None]
    return Jamming(channel, jnp.where(silent, np.float32(0), audible * emitters.level[:, None]))


def on_channels(jamming: Jamming, channels: jax.Array) -> tuple[jax.Array, jax.Array]:
    """All jammers' power on every channel: float32 [C, n + 2, ...], mW; and on the best of those in use: [n + 2, ...].

    One jammer after another is added, so that jammers that do not exist change no bit.
    """
    total, best = [], jnp.full_like(jamming.noise[0], jnp.inf)
    for channel in range(channels.shape[0]):
        power = jnp.zeros_like(jamming.noise[0])
        for on, noise in zip(jamming.channel, jamming.noise, strict=True):
            power = power + jnp.where(on == channel, noise, np.float32(0))
        total.append(power)
        best = jnp.where(channels[channel], jnp.minimum(best, power), best)
    return jnp.stack(total), best


def move(
    received: jax.Array, up: jax.Array | None, alive: jax.Array, state: State, arena: Arena, radio: RadioParameters
) -> State:
    """Let every jammer make its step, from what it hears in this one; arguments as of `answer`.

    alive: bool [...], whether the episode goes on.
    """
    assert state.jammers is not None
    emitters, power = _powers(received, state, arena)
    audible = power if up is None else jnp.where(up, power, np.float32(0))
    nodes = audible.shape[1]
    strongest = jnp.argmax(audible, axis=1)
    loudest = jnp.max(audible, axis=1)
    heard_x, heard_y = (_pick(at[:nodes], strongest) for at in (state.node_x, state.node_y))
    x, y = places(state)
    to_x, to_y = moved(
        emitters,
        Wandering(
            t=state.t,
            x=x,
            y=y,
            route_x=emitters.route_x,
            route_y=emitters.route_y,
            speed=emitters.speed,
            hears=loudest >= radio.sensitivity,
            heard_x=heard_x,
            heard_y=heard_y,
        ),
    )
    x, y = jnp.where(alive, to_x, x), jnp.where(alive, to_y, y)
    return dataclasses.replace(
        state,
        node_x=state.node_x.at[-1].set(x[0]),
        node_y=state.node_y.at[-1].set(y[0]),
        jammers=dataclasses.replace(state.jammers, x=x[1:], y=y[1:]),
    )


def _pick(places: jax.Array, index: jax.Array) -> jax.Array:
    """places[index[j]] for every jammer j: float32 [n + 2, ...] and int32 [J, ...] -> [J, ...]."""
    row = lift(np.arange(places.shape[0], dtype=np.int32), index)
    return jnp.sum(jnp.where(row == index, places[:, None], np.float32(0)), axis=0)


def places(state: State) -> tuple[jax.Array, jax.Array]:
    """Where all jammers are: float32 [J, ...] twice, m."""
    assert state.jammers is not None
    return (
        jnp.concatenate([state.node_x[-1:], state.jammers.x]),
        jnp.concatenate([state.node_y[-1:], state.jammers.y]),
    )


def notice(state: State, jamming: Jamming, radio: RadioParameters) -> State:
    """Enter every jammer whose noise reaches P_rs, with its place, the time and the greatest distance so far (xi)."""
    known = state.jammers
    assert known is not None
    n = state.x.shape[0]
    x, y = (at[:, None] for at in places(state))
    heard = jamming.noise[:, :n] >= radio.sensitivity
    distance = jnp.sqrt((x - state.x) ** 2 + (y - state.y) ** 2)
    return nearest(
        dataclasses.replace(
            state,
            jammers=dataclasses.replace(
                known,
                seen_time=jnp.where(heard, state.t, known.seen_time),
                seen_x=jnp.where(heard, x, known.seen_x),
                seen_y=jnp.where(heard, y, known.seen_y),
                seen_range=jnp.where(heard, jnp.maximum(known.seen_range, distance), known.seen_range),
            ),
        )
    )


def share(state: State, heard: jax.Array) -> State:
    """Merge what those know who were heard (bool [n, n, ...]): of a place the newest, of a range the greatest."""
    known = state.jammers
    assert known is not None
    time = known.seen_time
    told = jnp.where(heard, time[:, :, None], UNKNOWN)
    latest = jnp.max(told, axis=1)
    source = heard & (time[:, :, None] == latest[:, None])
    newer = latest > time

    def newest(place: jax.Array) -> jax.Array:
        said = jnp.max(jnp.where(source, place[:, :, None], -jnp.inf), axis=1)
        return jnp.where(newer, said, place)

    farthest = jnp.max(jnp.where(heard, known.seen_range[:, :, None], np.float32(0)), axis=1)
    return nearest(
        dataclasses.replace(
            state,
            jammers=dataclasses.replace(
                known,
                seen_time=jnp.maximum(time, latest),
                seen_x=newest(known.seen_x),
                seen_y=newest(known.seen_y),
                seen_range=jnp.maximum(known.seen_range, farthest),
            ),
        )
    )


def nearest(state: State) -> State:
    """Take as each agent's estimate the jammer whose last known place is nearest to it, the first of equals."""
    known = state.jammers
    assert known is not None
    index, _ = _nearest(state, known)
    return dataclasses.replace(state, jammer_range=take(known.seen_range, index))


def believed(state: State, arena: Arena) -> tuple[jax.Array, jax.Array]:
    """Where each agent believes the jammer to be that it knows of, the nearest if several: float32 twice, m.

    [n, ...]; [...] where there is but one that stays.
    """
    if state.jammers is None:
        return arena.jammer_x, arena.jammer_y
    index, _ = _nearest(state, state.jammers)
    return take(state.jammers.seen_x, index), take(state.jammers.seen_y, index)


def _nearest(state: State, known: JammerState) -> tuple[jax.Array, jax.Array]:
    squared = (known.seen_x - state.x) ** 2 + (known.seen_y - state.y) ** 2
    return least(known.seen_time > UNKNOWN, squared, jnp.float32(0))


def _powers(received: jax.Array, state: State, arena: Arena) -> tuple[Emitters, jax.Array]:
    """The emitters, and the power of all links with them: float32 [J, n + 2, ...], mW."""
    assert arena.emitters is not None
    assert state.jammers is not None
    return arena.emitters, jnp.concatenate([received[None], state.jammers.power])
