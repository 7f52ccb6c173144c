"""Roles: source-side, sink-side and closest among those known or heard (model section 4)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.vocabulary import SI, SO, SOURCE, C
from slcs2_jax.swarm import knowledge
from slcs2_jax.swarm.selection import rows
from slcs2_jax.swarm.state import State
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import SLACK
from slcs2_jax.world.stored import stored


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Candidates:
    """Whom an agent may mean: other agents at their last known places, the source, the sink where it believes it.

    Attributes:
        x, y: float32 [n + 2, n, ...], m.
        squared: float32 [n + 2, n, ...], m2, squared distance from self.
        known: bool [n + 2, n, ...], in K, or source or sink.
        source_side, sink_side: bool [n + 2, n, ...], nearer to the source (the sink) than self is.
    """

    x: jax.Array
    y: jax.Array
    squared: jax.Array
    known: jax.Array
    source_side: jax.Array
    sink_side: jax.Array


def candidates(state: State, arena: Arena) -> Candidates:
    """Place everybody as each agent knows them."""
    nodes_x, nodes_y = (
        jnp.broadcast_to(jnp.stack([jnp.zeros_like(sink), sink])[:, None], (2, *state.x.shape))
        for sink in (arena.estimate_x, arena.estimate_y)
    )
    x = jnp.concatenate([state.known_x, nodes_x])
    y = jnp.concatenate([state.known_y, nodes_y])
    known = jnp.concatenate([knowledge.known(state), jnp.ones((2, *state.x.shape), bool)])

    sink_x, sink_y = arena.estimate_x, arena.estimate_y
    return Candidates(
        x=x,
        y=y,
        squared=(x - state.x) ** 2 + (y - state.y) ** 2,
        known=known,
        source_side=x**2 + y**2 < _nearer(state.x**2 + state.y**2),
        sink_side=(sink_x - x) ** 2 + (sink_y - y) ** 2 < _nearer((sink_x - state.x) ** 2 + (sink_y - state.y) ** 2),
    )


def _nearer(squared: jax.Array) -> jax.Array:
    """The squared distance, m2, below which something is nearer beyond rounding."""
    return jnp.maximum(jnp.sqrt(squared) - np.float32(SLACK), np.float32(0)) ** 2


def closest(eligible: jax.Array, squared: jax.Array) -> jax.Array:
    """Distance to the closest eligible candidate, m; inf if there is none. [m, n, ...] -> float32 [n, ...]."""
    return jnp.sqrt(jnp.min(jnp.where(eligible, squared, jnp.inf), axis=0))


def resolve(target: jax.Array, members: jax.Array, everybody: Candidates, witness: jax.Array) -> jax.Array:
    """Which node each agent's target stands for: the closest of those with the role; the lowest index on ties.

    Ties are common, since agents stop at the clearance, so distances that differ by rounding only are one.

    Args:
        target: int32 [n, ...], a target of the vocabulary other than jammer or obstacle.
        members: bool [n + 2, n, ...], among whom roles are given: K for movement, N for sending.
        everybody: the candidates.
        witness: see ``stored``.

    Returns:
        int32 [n, ...], the node; n + 2 if the target is undefined.
    """
    count = members.shape[0]
    node = jnp.where(target == SOURCE, np.int32(count - 2), np.int32(count - 1))
    role = rows(count, target) == node
    role = jnp.where(target == SO, everybody.source_side, role)
    role = jnp.where(target == SI, everybody.sink_side, role)
    role = jnp.where(target == C, True, role)
    squared = stored(jnp.where(members & role, everybody.squared, jnp.inf), witness)
    tie = (jnp.sqrt(jnp.min(squared, axis=0)) + np.float32(SLACK)) ** 2
    equal = (squared <= tie) & (squared < jnp.inf)
    return jnp.min(jnp.where(equal, rows(count, target), np.int32(count)), axis=0)
