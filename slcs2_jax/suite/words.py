"""What hand-made entries say beyond the paper's vocabulary: clauses, targets and actions, made of what agents observe.

They are parts like any user's, but registered for nobody: a swarm that does not use them has the paper's vocabulary.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.vocabulary import CHANNELS, Vocabulary
from slcs2_jax.swarm.intent import Intent, send
from slcs2_jax.swarm.state import lift
from slcs2_jax.swarm.view import View
from slcs2_jax.world import randomness
from slcs2_jax.world.randomness import Purpose

SLOTS = 4  # hops after which a channel is used again
REST, TAUT = 0.5, 0.6  # shares of net: agents nearer than this push each other away; links longer than this pull
LANE, AHEAD = 15.0, 40.0  # m: of a lane from the line, and how far ahead on it one steers
PULL, HOLD = 0.5, 2.0  # strength beside a push of at most 1


def _number(view: View) -> np.ndarray:
    """Each agent's number: int32 [n, 1...]."""
    return lift(np.arange(view.x.shape[0], dtype=np.int32), view.state.t)


def _node(view: View) -> np.ndarray:
    """The number of every node, agents, source, sink: int32 [n + 2, 1, 1...]."""
    return lift(np.arange(view.x.shape[0] + 2, dtype=np.int32)[:, None], view.state.t)


def _ahead(view: View) -> jax.Array:
    """Agents and the sink, if heard and nearer to the sink than oneself: bool [n + 2, n, ...]."""
    return view.heard & view.everybody.sink_side & (_node(view) != view.x.shape[0])


def _others(view: View) -> jax.Array:
    """Other agents that are heard: bool [n, n, ...]."""
    n = view.x.shape[0]
    return view.heard[:n] & lift(~np.eye(n, dtype=bool), view.state.t)


def _uniform(view: View, number: np.ndarray) -> jax.Array:
    """A number in (0, 1) for each of these, drawn anew in every step."""
    stream = randomness.stream(view.state.key, view.state.t, Purpose.POLICY)
    return randomness.uniform(randomness.bits(stream, number.astype(np.uint32)))


def somebody_ahead(view: View) -> jax.Array:
    """Is an agent nearer to the sink, or the sink itself, in reach?"""
    return jnp.any(_ahead(view), axis=0)


def sink_in_reach(view: View) -> jax.Array:
    """Is the sink heard?"""
    return view.heard[view.x.shape[0] + 1]


def by_lot(view: View) -> jax.Array:
    """With chance one in as many as may want to send: oneself and the agents heard (slotted ALOHA; Abramson 1970)."""
    contenders = 1 + jnp.sum(_others(view).astype(jnp.int32), axis=0)
    return _uniform(view, _number(view)) * contenders.astype(jnp.float32) < 1


def first_in_line(view: View) -> jax.Array:
    """Is it the first of the chain?"""
    return jnp.broadcast_to(_number(view) == 0, view.x.shape)


def my_turn(view: View) -> jax.Array:
    """Is it the slot of one's own hop?"""
    return (view.state.t - _number(view)) % np.int32(SLOTS) == 0


def turn_before(view: View) -> jax.Array:
    """Is it the slot of the hop before one's own?"""
    return (view.state.t - _number(view) + np.int32(1)) % np.int32(SLOTS) == 0


def _post(view: View) -> tuple[jax.Array, jax.Array]:
    """Agents by number at even distances on the line from source to sink: m."""
    share = jnp.asarray((_number(view) + 1).astype(np.float32) / np.float32(view.x.shape[0] + 1))
    return share * view.arena.estimate_x, share * view.arena.estimate_y


def post(view: View) -> tuple[jax.Array, jax.Array, jax.Array]:
    """One's own place in the chain; known until it is reached, to two steps."""
    x, y = _post(view)
    far = (x - view.x) ** 2 + (y - view.y) ** 2 > (2 * view.swarm.speed) ** 2
    return x, y, far


def away_from_post(view: View) -> jax.Array:
    """Is one's place in the chain not reached?"""
    return post(view)[2]


def _lane(view: View, forth: int) -> tuple[jax.Array, jax.Array, jax.Array]:
    """A place ahead on one's own side of the line from source to sink, so that no two meet head on: m.

    forth: 1 toward the sink, -1 toward the source; nearer than d_th to that, it is the place.
    """
    sink_x, sink_y = view.arena.estimate_x, view.arena.estimate_y
    length = jnp.sqrt(sink_x**2 + sink_y**2)
    east_x, east_y = sink_x / length, sink_y / length
    along = view.x * east_x + view.y * east_y + np.float32(forth * AHEAD)
    side = np.float32(forth * LANE)
    end_x, end_y = (sink_x, sink_y) if forth > 0 else (0 * sink_x, 0 * sink_y)
    near = (view.left[3] if forth > 0 else view.left[4]) < view.swarm.distance_threshold
    x = jnp.where(near, end_x, along * east_x + side * east_y)
    y = jnp.where(near, end_y, along * east_y - side * east_x)
    return x, y, jnp.ones_like(view.holding)


def lane_to_sink(view: View) -> tuple[jax.Array, jax.Array, jax.Array]:
    """The way out, on the right."""
    return _lane(view, 1)


def lane_to_source(view: View) -> tuple[jax.Array, jax.Array, jax.Array]:
    """The way back, on its right."""
    return _lane(view, -1)


def balance(view: View) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Where virtual forces pull (Zou and Chakrabarty 2003; Howard, Mataric and Sukhatme 2002), m.

    Whoever is known and nearer than REST net pushes away, the more the nearer; the closest one on the source's side
    pulls back once it is farther than TAUT net; where nobody on the sink's side is within REST net, the sink pulls.
    """
    net, everybody = view.radio.network_range, view.everybody
    away_x, away_y = view.x - everybody.x, view.y - everybody.y
    distance = jnp.sqrt(jnp.maximum(everybody.squared, np.float32(1e-6)))
    others = everybody.known & (_node(view) != _number(view))
    push = jnp.where(others, jnp.maximum(np.float32(1) - distance / (np.float32(REST) * net), np.float32(0)), 0)
    behind = others & everybody.source_side & (everybody.squared == _least(others & everybody.source_side, view))
    hold = jnp.where(behind & (distance > np.float32(TAUT) * net), np.float32(-HOLD), np.float32(0))
    weight = (push + hold) / distance
    to_sink_x, to_sink_y = view.arena.estimate_x - view.x, view.arena.estimate_y - view.y
    pulled = jnp.where(view.left[1] > np.float32(REST) * net, np.float32(PULL), np.float32(0))
    pulled = pulled / jnp.maximum(view.left[3], np.float32(1))
    force_x = jnp.sum(weight * away_x, axis=0) + pulled * to_sink_x
    force_y = jnp.sum(weight * away_y, axis=0) + pulled * to_sink_y
    size = jnp.sqrt(force_x**2 + force_y**2)
    far = net / jnp.maximum(size, np.float32(1e-6))
    return view.x + far * force_x, view.y + far * force_y, size > np.float32(0.05)


def off_balance(view: View) -> jax.Array:
    """Do the forces leave more than a twentieth of the strongest push?"""
    return balance(view)[2]


def _least(eligible: jax.Array, view: View) -> jax.Array:
    """Squared distance of the closest of those, m2: float32 [1, n, ...]."""
    return jnp.min(jnp.where(eligible, view.everybody.squared, jnp.inf), axis=0, keepdims=True)


def send_to_foremost(view: View) -> Intent:
    """To the one in reach who is nearest to the sink (greedy mode of GPSR; Karp and Kung 2000)."""
    left_x, left_y = (
        view.arena.estimate_x - view.everybody.x,
        view.arena.estimate_y - view.everybody.y,
    )
    left = jnp.where(_ahead(view), left_x**2 + left_y**2, jnp.inf)
    node = jnp.argmin(left, axis=0).astype(jnp.int32)
    return send(view, jnp.where(somebody_ahead(view), node, np.int32(view.x.shape[0] + 2)))


def send_to_anyone(view: View) -> Intent:
    """To one of the agents in reach, drawn at random."""
    n, others = view.x.shape[0], _others(view)
    pair = lift(np.arange(n, n + n * n, dtype=np.int32).reshape(n, n), view.state.t)
    drawn = jnp.where(others, _uniform(view, pair), np.float32(-1))
    return send(view, jnp.where(jnp.any(others, axis=0), jnp.argmax(drawn, axis=0).astype(jnp.int32), np.int32(n + 2)))


def next_in_reach(view: View) -> jax.Array:
    """Is the next one of the chain, or behind the last the sink, heard?"""
    node = jnp.broadcast_to(_next(view), view.x.shape)
    return jnp.any(view.heard & (_node(view) == node), axis=0)


def send_to_next(view: View) -> Intent:
    """To the agent of the next number; the last to the sink."""
    return send(view, jnp.broadcast_to(_next(view), view.x.shape))


def _next(view: View) -> np.ndarray:
    """Number of the next node in the chain: int32 [n, 1...]."""
    n, number = view.x.shape[0], _number(view)
    return np.where(number == n - 1, np.int32(n + 1), number + np.int32(1))


VOCABULARY = Vocabulary(
    CHANNELS,
    own_clauses=(
        ("somebody ahead in reach", somebody_ahead),
        ("sink in reach", sink_in_reach),
        ("by lot", by_lot),
        ("first in line", first_in_line),
        ("my turn", my_turn),
        ("turn before mine", turn_before),
        ("away from post", away_from_post),
        ("next in reach", next_in_reach),
        ("off balance", off_balance),
    ),
    own_targets=(
        ("post", post),
        ("balance", balance),
        ("lane to sink", lane_to_sink),
        ("lane to source", lane_to_source),
    ),
    own_actions=(
        ("send to foremost", send_to_foremost),
        ("send to anyone", send_to_anyone),
        ("send to next", send_to_next),
    ),
)
