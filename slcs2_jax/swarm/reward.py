"""The reward of a step (paper, reward equation)."""

from __future__ import annotations

import dataclasses
from typing import Protocol

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm.outcome import Outcome
from slcs2_jax.swarm.state import State
from slcs2_jax.swarm.view import View


class Reward(Protocol):
    """What a step is worth to each agent; part of compiled programs, so hashable and unchanging."""

    def __call__(self, view: View, after: State, outcome: Outcome) -> jax.Array:
        """float32 [n, ...]; meaningless for agents that did not act. Must be finite.

        Args:
            view: the time-step before anybody acted.
            after: the state that the actions led to.
            outcome: what everybody was about, and what became of the transmissions.
        """


@dataclasses.dataclass(frozen=True)
class Progress:
    """The paper's: the approach of packets to the sink, else the agent's own to the source, less the action's cost."""

    def __call__(self, view: View, after: State, outcome: Outcome) -> jax.Array:
        """rho = ln(|rho_p| + 1) sgn(rho_p) + rho_s - C_a: float32 [n, ...].

        ``rho_p`` adds up the approach to the sink, in m, of the packet held through the step and of packets transferred
        and received; a transfer credits sender and receiver alike, from the places before the step. ``rho_s`` is the
        approach to the source of an agent that had no packet in the step. Distances to the sink are to where the agents
        believe it.
        """
        before, arena, air, intent = view.state, view.arena, outcome.air, outcome.intent
        n = before.x.shape[0]
        passed = jnp.any(air.accepted, axis=0)
        sent = jnp.any(passed[:n], axis=1)
        received = jnp.any(passed[:, :n], axis=0)
        kept = before.holding & ~sent

        def to_sink(x: jax.Array, y: jax.Array) -> jax.Array:
            return jnp.sqrt((arena.estimate_x - x) ** 2 + (arena.estimate_y - y) ** 2)

        origin = jnp.zeros_like(arena.sink_x)
        here = to_sink(before.x, before.y)
        nodes = to_sink(jnp.stack([origin, arena.sink_x]), jnp.stack([origin, arena.sink_y]))
        places = jnp.concatenate([here, nodes])
        approach = jnp.where(passed, places[: n + 1, None] - places, np.float32(0))
        packets = (
            jnp.where(kept, here - to_sink(after.x, after.y), np.float32(0))
            + jnp.sum(approach[:n], axis=1)
            + jnp.sum(approach[:, :n], axis=0)
        )
        moved = jnp.sqrt(before.x**2 + before.y**2) - jnp.sqrt(after.x**2 + after.y**2)
        seeking = jnp.where(before.holding | received, np.float32(0), moved)
        cost = jnp.where(intent.moves, view.swarm.cost_move, view.swarm.cost_communicate)
        return jnp.log(jnp.abs(packets) + np.float32(1)) * jnp.sign(packets) + seeking - cost
