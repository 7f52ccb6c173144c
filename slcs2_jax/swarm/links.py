"""The links of a time-step: received powers between all nodes, the jammer's answer, who hears whom (model 3)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm import jamming as jammers
from slcs2_jax.swarm.jamming import WORDS, Jamming
from slcs2_jax.swarm.state import State, lift
from slcs2_jax.world import randomness
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import count_crossings
from slcs2_jax.world.radio import RadioParameters, decodable, received_power
from slcs2_jax.world.stored import stored


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Links:
    """The radio of one step. Nodes: agents 0..n-1, source n, sink n+1.

    Attributes:
        power: float32 [n + 2, n + 2, ...], mW received at full power, [sender, receiver]; 0 on the diagonal.
        jamming: float32 [C, n + 2, ...], mW received from all jammers on each channel.
        heard: bool [n + 2, n, ...], whose beacons each agent decoded.
        jammers: each jammer's part; None where there is none but one that stays and answers.
    """

    power: jax.Array
    jamming: jax.Array
    heard: jax.Array
    jammers: Jamming | None = None


def drawn(state: State, arena: Arena, radio: RadioParameters) -> State:
    """The state with all links of time-step ``state.t``."""
    state = dataclasses.replace(state, power=draw(state, arena, radio))
    if state.jammers is None:
        return state
    further = dataclasses.replace(state.jammers, power=jammers.draw(state, arena, radio))
    return dataclasses.replace(state, jammers=further)


def draw(state: State, arena: Arena, radio: RadioParameters) -> jax.Array:
    """The links of time-step ``state.t`` between all nodes: float32 [rows, n + 3, ...], mW at full power, folded.

    Drawn when the step before ends and kept in the state: so the powers, which are costly, are computed once and
    stored, whatever the compiler makes of those who read them.
    """
    x1, x2 = _ends(state.node_x)
    y1, y2 = _ends(state.node_y)
    number = lift(_number(state.node_x.shape[0]), state.t)
    stream = stored(randomness.stream(state.key, state.t, randomness.Purpose.SHADOWING), radio.sensitivity)

    def words(k: int) -> jax.Array:
        if k == 0:
            return randomness.bits(stream, number)
        more = stored(randomness.stream(state.key, state.t, randomness.Purpose.FADING), radio.sensitivity)
        return randomness.bits(more, number + np.uint32(k * WORDS))

    squared = (x2 - x1) ** 2 + (y2 - y1) ** 2
    walls = count_crossings(x1, y1, x2, y2, arena.walls)
    return received_power(squared, walls, radio.fading.gain(words), radio)


def measure(state: State, arena: Arena, radio: RadioParameters) -> Links:
    """What the links drawn for the step carry: let the jammers answer, and see who hears whom."""
    power = _unfold(state.power)
    nodes = power.shape[0] - 1
    at_jammer = power[:nodes, nodes]
    between = power[:nodes, :nodes]
    up = working(state)
    if up is not None:
        between = jnp.where(up & up[:, None], between, np.float32(0))
    if arena.emitters is None:
        audible = at_jammer if up is None else jnp.where(up, at_jammer, np.float32(0))
        active = arena.has_jammer & jnp.any(audible >= radio.sensitivity, axis=0)
        noise = jnp.where(active, power[nodes, :nodes] if up is None else audible, np.float32(0))
        # Beacons go out on every channel in use: the jammer hears them on the first of these and jams that one, and a
        # beacon that is jammed there is still decoded on another.
        first, escape = _first_in_use(arena.channels)
        jamming = jnp.where(first[:, None], noise, np.float32(0))
        least = jnp.where(escape, np.float32(0), noise[: nodes - 2])
        every = None
    else:
        every = jammers.answer(at_jammer, up, state, arena, radio)
        jamming, best = jammers.on_channels(every, arena.channels)
        least = best[: nodes - 2]
    heard = decodable(between[:, : nodes - 2], least, radio)
    return Links(power=between, jamming=jamming, heard=heard, jammers=every)


def moved_jammers(state: State, alive: jax.Array, arena: Arena, radio: RadioParameters) -> State:
    """The state with the jammers where the step that ends takes them, from what they heard in it."""
    if arena.emitters is None:
        return state
    return jammers.move(_unfold(state.power)[:-1, -1], working(state), alive, state, arena, radio)


def working(state: State) -> jax.Array | None:
    """Which nodes work: bool [n + 2, ...]; None where nobody ever fails. Source and sink always do."""
    if state.down is None:
        return None
    return jnp.concatenate([~state.down, jnp.ones((2, *state.down.shape[1:]), bool)])


def _first_in_use(channels: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Mark the first channel in use (bool [C, ...]), and whether there is another (bool [...])."""
    earlier = jnp.zeros_like(channels[0])
    first, several = [], earlier
    for used in channels:
        first.append(used & ~earlier)
        several = several | (used & earlier)
        earlier = earlier | used
    return jnp.stack(first), several


# Each link is computed once. The upper triangle of the table of links, sender < receiver, is folded into its upper
# half: row r holds the links (r, c) for c > r and, in the room that these leave, the links of row count - 1 - r turned
# round.


def _folded(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Folded place -> ends of the link (int32 [rows, count] twice), and whether it is of the row itself."""
    row, column = np.indices((-(-count // 2), count), np.int32)
    upright = column >= row
    last = np.int32(count - 1)
    return np.where(upright, row, last - row), np.where(upright, column, last - column), upright


def _number(count: int) -> np.ndarray:
    """Name of each folded link for its random draw: uint32 [rows, count]."""
    one, other, _ = _folded(count)
    return (one * count + other).astype(np.uint32)


def _ends(position: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Coordinates of both ends of each folded link: [count, ...] -> [rows, count, ...] twice."""
    count = position.shape[0]
    _, _, upright = _folded(count)
    turned = position[::-1]
    upright = lift(upright, position[0])
    one = jnp.where(upright, position[: upright.shape[0], None], turned[: upright.shape[0], None])
    return one, jnp.where(upright, position, turned)


def _unfold(links: jax.Array) -> jax.Array:
    """The symmetric table with a zero diagonal of folded links: [rows, count, ...] -> [count, count, ...]."""
    rows, count = links.shape[:2]
    below = links[: count - rows][::-1, ::-1]
    upper = lift(np.triu(np.ones((count, count), bool), 1), links[0, 0])
    table = jnp.where(upper, jnp.concatenate([links, below]), np.float32(0))
    return table + jnp.swapaxes(table, 0, 1)
