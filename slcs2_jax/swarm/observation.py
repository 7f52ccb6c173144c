"""What an agent observes, and the truth of every clause that a rule may state (spec sections 4 and 5)."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.vocabulary import CLAUSES, MASK_WORDS
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.roles import Candidates, closest
from slcs2_jax.swarm.state import State, SwarmParameters
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import SLACK
from slcs2_jax.world.radio import RadioParameters
from slcs2_jax.world.stored import stored

WORD_BITS = 32


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Observation:
    """All that a controller may base a decision on.

    Attributes:
        truth: uint32 [W, n, ...], bit k % 32 of word k // 32 tells whether clause k of the vocabulary holds.
        left: float32 [5, n, ...], m, distances to so, si, c, sink and source; inf if undefined.
        right: float32 [6, n, ...], m, so, si, c, d_th, net and the jammer's range; inf if undefined.
        holding: bool [n, ...].
        node_heard: bool [n, ...], source or sink is in N.
        interference: float32 [C, n, ...], mW, NI of the last step.
        heard: bool [n + 2, n, ...], N.
        everybody: K and the nodes, with places and distances.
        jammer_range: float32 [n, ...], m, 0 while no jammer is known.
        running: bool [...], False once the episode is over.
    """

    truth: jax.Array
    left: jax.Array
    right: jax.Array
    holding: jax.Array
    node_heard: jax.Array
    interference: jax.Array
    heard: jax.Array
    everybody: Candidates
    jammer_range: jax.Array
    running: jax.Array


def observe(
    state: State,
    links: Links,
    everybody: Candidates,
    arena: Arena,
    radio: RadioParameters,
    parameters: SwarmParameters,
    running: jax.Array,
) -> Observation:
    """Form each agent's observation. Nothing is true for the agents of an episode that is over."""
    sides: list[Any] = [everybody.source_side, everybody.sink_side, True]
    roles = [closest(everybody.known & side, everybody.squared) for side in sides]
    to_sink = jnp.sqrt((arena.estimate_x - state.x) ** 2 + (arena.estimate_y - state.y) ** 2)
    to_source = jnp.sqrt(state.x**2 + state.y**2)
    everywhere = jnp.ones_like(state.x)
    jammer = jnp.where(state.jammer_range > 0, state.jammer_range, jnp.inf)
    left = [*roles, to_sink, to_source]
    right = [*roles, everywhere * parameters.distance_threshold, everywhere * radio.network_range, jammer]
    node_heard = jnp.any(links.heard[-2:], axis=0)
    holds = {
        "packet": state.holding,
        "no_packet": ~state.holding,
        "node": node_heard,
        "no_node": ~node_heard,
        "noise": state.interference <= radio.sensitivity,
        "distance": _compare(left, right, parameters),
    }
    return Observation(
        truth=stored(jnp.where(running, _pack(holds), np.uint32(0)), parameters.speed),
        left=jnp.stack(left),
        right=jnp.stack(right),
        holding=state.holding,
        node_heard=node_heard,
        interference=state.interference,
        heard=links.heard,
        everybody=everybody,
        jammer_range=state.jammer_range,
        running=running,
    )


def _compare(
    left: list[jax.Array], right: list[jax.Array], parameters: SwarmParameters
) -> dict[tuple[int, int, int], jax.Array]:
    """Truth of every distance clause (left operand, operator, right operand): bool [n, ...] each.

    An undefined operand makes its clause false under every operator. Equality has a tolerance of one step of motion or
    a share of the right operand, whichever is more, and does not exclude ``<`` and ``>``, which need a difference
    beyond rounding: the same distance may be computed in two ways.
    """
    holds = {}
    for j, b in enumerate(right):
        tolerance = jnp.maximum(parameters.speed, parameters.tolerance * b) + np.float32(SLACK)
        for i, a in enumerate(left):
            defined = (a < jnp.inf) & (b < jnp.inf)
            holds[i, 0, j] = a < b - np.float32(SLACK)
            holds[i, 1, j] = a > b + np.float32(SLACK)
            holds[i, 2, j] = (a <= b + tolerance) & (a >= b - tolerance)
            for operator in range(3):
                holds[i, operator, j] &= defined
    return holds


def _pack(holds: dict[str, Any]) -> jax.Array:
    """Truth of the vocabulary's clauses as bits: uint32 [W, n, ...]."""
    words = [jnp.zeros(holds["packet"].shape, jnp.uint32)] * MASK_WORDS
    for number, clause in enumerate(CLAUSES):
        if clause.kind == "noise":
            if clause.channel >= holds["noise"].shape[0]:
                continue  # a channel that is not simulated, because no grammar of the batch uses it
            truth = holds["noise"][clause.channel]
        elif clause.kind == "distance":
            truth = holds["distance"][clause.left, clause.operator, clause.right]
        else:
            truth = holds[clause.kind]
        word, bit = divmod(number, WORD_BITS)
        words[word] |= jnp.where(truth, np.uint32(1 << bit), np.uint32(0))
    return jnp.stack(words)
