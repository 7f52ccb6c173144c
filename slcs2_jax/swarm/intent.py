"""What an action means for the agent that takes it: kind, target node or place, channel and power (spec section 4)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar import vocabulary
from slcs2_jax.swarm import jamming, roles
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.selection import least, take
from slcs2_jax.swarm.state import State, SwarmParameters, lift
from slcs2_jax.world import geometry
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import Nearest
from slcs2_jax.world.radio import RadioParameters


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Intent:
    """Decoded actions, all [n, ...].

    Attributes:
        acts, moves, collects, sends: bool, whether the agent does anything, and of what kind.
        direction: int32, a direction of the vocabulary, for moves.
        place_x, place_y: float32, m, the target of a move.
        place_known: bool, whether that target is defined.
        node: int32, the node to send to; n + 2 if undefined.
        channel: int32, index of the channel to communicate on.
        level: float32, power as a ratio of full power.
    """

    acts: jax.Array
    moves: jax.Array
    collects: jax.Array
    sends: jax.Array
    direction: jax.Array
    place_x: jax.Array
    place_y: jax.Array
    place_known: jax.Array
    node: jax.Array
    channel: jax.Array
    level: jax.Array


def interpret(
    action: jax.Array,
    observation: Observation,
    state: State,
    arena: Arena,
    radio: RadioParameters,
    parameters: SwarmParameters,
) -> Intent:
    """Resolve actions (int32 [n, ...], numbers of the vocabulary) against what the agents know and hear."""
    moves = action < vocabulary.FIRST_COLLECT
    collects = (action >= vocabulary.FIRST_COLLECT) & (action < vocabulary.FIRST_SEND)
    sends = (action >= vocabulary.FIRST_SEND) & (action < vocabulary.N_ACTIONS)
    direction, move_target = _divide(action, len(vocabulary.MOVE_TARGETS))
    settings = len(vocabulary.CHANNELS) * len(vocabulary.POWERS)
    send_target, send_setting = _divide(action - vocabulary.FIRST_SEND, settings)
    target = jnp.where(moves, move_target, send_target)
    channel, power = _divide(jnp.where(sends, send_setting, action - vocabulary.FIRST_COLLECT), len(vocabulary.POWERS))
    members = jnp.where(sends, observation.heard, observation.everybody.known)
    node = roles.resolve(target, members, observation.everybody, parameters.speed)
    place_x, place_y = take(observation.everybody.x, node), take(observation.everybody.y, node)
    obstacle = nearest_obstacle(state, arena, parameters)
    jammer_x, jammer_y = jamming.believed(state, arena)
    to_obstacle = target == vocabulary.OBSTACLE
    to_jammer = target == vocabulary.JAMMER
    known = jnp.where(
        to_obstacle,
        obstacle.squared <= (parameters.lidar_range + np.float32(geometry.SLACK)) ** 2,
        jnp.where(to_jammer, state.jammer_range > 0, node < members.shape[0]),
    )
    return Intent(
        acts=action < vocabulary.N_ACTIONS,
        moves=moves,
        collects=collects,
        sends=sends,
        direction=direction,
        place_x=jnp.where(to_obstacle, obstacle.x, jnp.where(to_jammer, jammer_x, place_x)),
        place_y=jnp.where(to_obstacle, obstacle.y, jnp.where(to_jammer, jammer_y, place_y)),
        place_known=known,
        node=node,
        channel=channel,
        level=jnp.where(power == vocabulary.FULL, jnp.float32(1), radio.half_power),
    )


def _divide(number: jax.Array, by: int) -> tuple[jax.Array, jax.Array]:
    """Quotient and remainder of small numbers (0..255), by multiplication: vector units cannot divide integers."""
    quotient = (number * np.int32(2**12 // by + 1)) >> np.int32(12)
    return quotient, number - quotient * np.int32(by)


def nearest_obstacle(state: State, arena: Arena, parameters: SwarmParameters) -> Nearest:
    """Nearest point of a wall's surface, or of another agent, at any distance (spec 4, ``o``); walls first on ties."""
    n = state.x.shape[0]
    others = lift(~np.eye(n, dtype=bool), state.t)
    x, y = (jnp.broadcast_to(a[:, None], others.shape[:2] + a.shape[1:]) for a in (state.x, state.y))
    index, squared = least(others, (x - state.x) ** 2 + (y - state.y) ** 2, parameters.speed)
    best = geometry.nearest_wall(state.x, state.y, parameters.half_thickness, arena.walls)
    return best.or_nearer(squared, take(x, index), take(y, index))
