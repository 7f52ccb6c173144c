"""What an action means for the agent that takes it: kind, target, channel and power (paper, Appendix A)."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import FULL, JAMMER, MOVE_TARGETS, OBSTACLE, POWERS, TOWARD
from slcs2_jax.swarm import jamming, roles
from slcs2_jax.swarm.selection import least, take
from slcs2_jax.swarm.state import State, SwarmParameters, lift
from slcs2_jax.swarm.view import View, checked
from slcs2_jax.world import geometry
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import Nearest


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


def interpret(action: jax.Array, view: View, language: Language) -> Intent:
    """Resolve actions (int32 [n, ...], numbers of the vocabulary) against what the agents know and hear."""
    state, arena, radio, parameters = view.state, view.arena, view.radio, view.swarm
    vocabulary = language.vocabulary
    first_collect, first_send, first_own = vocabulary.first_collect, vocabulary.first_send, vocabulary.first_own
    moves = action < first_collect
    collects = (action >= first_collect) & (action < first_send)
    sends = (action >= first_send) & (action < first_own)
    direction, move_target = _divide(action, len(MOVE_TARGETS))
    send_target, send_setting = _divide(action - first_send, vocabulary.settings)
    target = jnp.where(moves, move_target, send_target)
    channel, power = _divide(jnp.where(sends, send_setting, action - first_collect), len(POWERS))
    members = jnp.where(sends, view.heard, view.everybody.known)
    node = roles.resolve(target, members, view.everybody, parameters.speed)
    place_x, place_y = take(view.everybody.x, node), take(view.everybody.y, node)
    obstacle = nearest_obstacle(state, arena, parameters)
    jammer_x, jammer_y = jamming.believed(state, arena)
    to_obstacle = target == OBSTACLE
    to_jammer = target == JAMMER
    known = jnp.where(
        to_obstacle,
        obstacle.squared <= (parameters.lidar_range + np.float32(geometry.SLACK)) ** 2,
        jnp.where(to_jammer, state.jammer_range > 0, node < members.shape[0]),
    )
    intent = Intent(
        acts=action < len(vocabulary.actions),
        moves=moves,
        collects=collects,
        sends=sends,
        direction=direction,
        place_x=jnp.where(to_obstacle, obstacle.x, jnp.where(to_jammer, jammer_x, place_x)),
        place_y=jnp.where(to_obstacle, obstacle.y, jnp.where(to_jammer, jammer_y, place_y)),
        place_known=known,
        node=node,
        channel=channel,
        level=jnp.where(power == FULL, jnp.float32(1), radio.half_power),
    )
    return _with_own(intent, action, view, language)


def _divide(number: jax.Array, by: int) -> tuple[jax.Array, jax.Array]:
    """Quotient and remainder of small numbers (0..255), by multiplication: vector units cannot divide integers."""
    quotient = (number * np.int32(2**12 // by + 1)) >> np.int32(12)
    return quotient, number - quotient * np.int32(by)


def nearest_obstacle(state: State, arena: Arena, parameters: SwarmParameters) -> Nearest:
    """Nearest point of a wall's surface, or of another agent, at any distance (``o``); walls first on ties."""
    n = state.x.shape[0]
    others = lift(~np.eye(n, dtype=bool), state.t)
    x, y = (jnp.broadcast_to(a[:, None], others.shape[:2] + a.shape[1:]) for a in (state.x, state.y))
    index, squared = least(others, (x - state.x) ** 2 + (y - state.y) ** 2, parameters.speed)
    best = geometry.nearest_wall(state.x, state.y, parameters.half_thickness, arena.walls)
    return best.or_nearer(squared, take(x, index), take(y, index))


# Users' targets and actions. A target is a function of the view that returns x, y and whether it is defined; an action
# is one that returns what the agents would do: `move`, `collect` or `send`.


def move(view: View, x: Any, y: Any, *, known: Any = True, direction: int = TOWARD) -> Intent:
    """Move toward, away from or around a place, m: numbers or arrays that can be spread to [n, ...].

    direction: one of TOWARD, AWAY, ORBIT of the vocabulary. Where the place is not known nothing happens.
    """
    place = {"place_x": x, "place_y": y, "place_known": known, "direction": direction}
    return _intent(view, "moves", place)


def collect(view: View, *, channel: Any = 0, level: Any = 1.0) -> Intent:
    """Ask the source for a packet on a channel (its index) at a share of full power."""
    return _intent(view, "collects", {"channel": channel, "level": level})


def send(view: View, node: Any, *, channel: Any = 0, level: Any = 1.0) -> Intent:
    """Send the packet held to a node: an agent's number, n for the source, n + 1 for the sink, n + 2 for nobody."""
    return _intent(view, "sends", {"node": node, "channel": channel, "level": level})


_TYPES = {
    **dict.fromkeys(("acts", "moves", "collects", "sends", "place_known"), np.bool_),
    **dict.fromkeys(("direction", "node", "channel"), np.int32),
    **dict.fromkeys(("place_x", "place_y", "level"), np.float32),
}


def _intent(view: View, kind: str, given: dict[str, Any]) -> Intent:
    """An intent of one kind for everybody; what is not given means nothing."""
    values = dict.fromkeys(_TYPES, 0) | {"acts": True, kind: True, "node": view.x.shape[0] + 2, "level": 1.0} | given
    arrays = {name: jnp.asarray(values[name], _TYPES[name]) for name in _TYPES}
    return Intent(**{name: checked(kind, name, array, view.x, _TYPES[name]) for name, array in arrays.items()})


def _with_own(intent: Intent, action: jax.Array, view: View, language: Language) -> Intent:
    """The intent of those who take an action of a user's, in place of what its number would mean otherwise."""
    vocabulary, actions = language.vocabulary, language.vocabulary.actions
    places: dict[int, Any] = {}
    for number in language.own_actions:
        known = actions[number]
        if known.kind == "move":
            own = known.target - len(MOVE_TARGETS)
            if own not in places:
                places[own] = _place(*vocabulary.own_targets[own], view)
            x, y, defined = places[own]
            meant = move(view, x, y, known=defined, direction=known.direction)
        else:
            name, part = vocabulary.own_actions[known.own]
            try:
                meant = part(view)
            except InputError as error:
                raise InputError(f"action {name!r}: {error}") from None
            if not isinstance(meant, Intent):
                raise InputError(f"action {name!r}: returned {type(meant).__name__}; accepted is move, collect or send")
        chosen = action == number
        intent = jax.tree.map(partial(jnp.where, chosen), meant, intent)
    return intent


def _place(name: str, part: Any, view: View) -> tuple[jax.Array, ...]:
    """Where a user's target is, and whether it is defined."""
    value = part(view)
    if not isinstance(value, tuple) or len(value) != 3:
        raise InputError(
            f"move target {name!r}: returned {type(value).__name__}; accepted are x, y and whether it is known"
        )
    types = (np.float32, np.float32, np.bool_)
    return tuple(checked("move target", name, one, view.x, dtype) for one, dtype in zip(value, types, strict=True))
