"""Episodes side by side that a network acts in, and what there is to learn from them.

T steps, n agents, B episodes, F figures, A actions and to do nothing, C remembered. What the swarm is made of has the
batch last, as everywhere; what the network is given has the agents first and then the batch, [n, B, ...].
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.learning import objective
from slcs2_jax.policy import layers
from slcs2_jax.policy.network import Network
from slcs2_jax.policy.policy import Clock
from slcs2_jax.swarm import knowledge
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.state import State
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import Arena


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Episodes:
    """Episodes under way.

    Attributes:
        arena: their worlds.
        state: their swarms.
        memory: float32 [n, B, C], what agents remember.
    """

    arena: Arena
    state: State
    memory: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Steps:
    """What was seen, done and earned.

    Attributes:
        figures: float32 [T, n, B, F].
        mask: bool [T, n, B, A + 1].
        memory: float32 [T, n, B, C], before the step.
        action: int32 [T, n, B], places among the A + 1.
        log_probability: float32 [T, n, B], of that action.
        value: float32 [T, n, B], what the network expected, in its own unit.
        reward: float32 [T, n, B]; 0 for who did nothing.
        able: bool [T, n, B], who could act: nobody in an episode that is over, and nobody who is down.
        running: bool [T, B], the episode was not over before the step.
        terminated: bool [T, B], the task was done with this step.
        over: bool [T, B], the episode ended with this step or before.
    """

    figures: jax.Array
    mask: jax.Array
    memory: jax.Array
    action: jax.Array
    log_probability: jax.Array
    value: jax.Array
    reward: jax.Array
    able: jax.Array
    running: jax.Array
    terminated: jax.Array
    over: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Collector:
    """Makes steps of episodes. Pure code, to be compiled; the physics are an argument of it and no constants.

    policy: how a network sees and acts. physics: of the world, which every episode shares. period: of sharing, steps.
    """

    physics: Physics
    policy: Network = dataclasses.field(metadata={"static": True})
    period: int = dataclasses.field(metadata={"static": True})

    def begin(self, arena: Arena, key: jax.Array) -> Episodes:
        """Deploy swarms: arena of B worlds, key uint32 [2, B]."""
        memory = jnp.zeros((*arena.start_x.shape, self.policy.carry), jnp.float32)
        return Episodes(arena, swarm.begin(arena, key, self.physics), memory)

    def refill(self, episodes: Episodes, arena: Arena, key: jax.Array, entering: jax.Array) -> Episodes:
        """Begin anew, with nothing remembered, where `entering`, bool [B]."""
        fresh = self.begin(arena, key)

        def chosen(new: jax.Array, old: jax.Array) -> jax.Array:
            return jnp.where(entering, new, old)

        memory = jnp.where(entering[:, None], fresh.memory, episodes.memory)
        return Episodes(
            jax.tree.map(chosen, fresh.arena, episodes.arena), jax.tree.map(chosen, fresh.state, episodes.state), memory
        )

    def collect(self, network: Any, value: Any, episodes: Episodes, steps: int) -> tuple[Episodes, Steps, jax.Array]:
        """Make so many steps, whole sharing periods; an episode that is over stands still.

        Args:
            network: of `policy.layers`.
            value: the layer that values are read with, from what the network's last layer looks at.
            episodes: see there.
            steps: T.

        Returns:
            The episodes, the steps, and the value of what comes after the last, float32 [n, B].
        """
        arena = episodes.arena

        def one_step(carry: tuple[State, jax.Array], _: None) -> tuple[tuple[State, jax.Array], Steps]:
            return self._step(network, value, arena, *carry)

        def one_period(carry: tuple[State, jax.Array], _: None) -> tuple[tuple[State, jax.Array], Steps]:
            (state, memory), noted = jax.lax.scan(one_step, carry, length=self.period)
            return (knowledge.share(state), memory), noted

        start = (episodes.state, episodes.memory)
        (state, memory), noted = jax.lax.scan(one_period, start, length=steps // self.period)
        _, seen = swarm.observe(state, arena, self.physics)
        _, hidden = layers.forward(network, memory, _agents_first(self.policy.figures(seen)))
        noted = jax.tree.map(lambda leaf: leaf.reshape(steps, *leaf.shape[2:]), noted)
        return Episodes(arena, state, memory), noted, layers.head(value, hidden)[..., 0]

    def _step(
        self, network: Any, value: Any, arena: Arena, state: State, memory: jax.Array
    ) -> tuple[tuple[State, jax.Array], Steps]:
        state, seen = swarm.observe(state, arena, self.physics)
        figures, mask = _agents_first(self.policy.figures(seen)), self.policy.mask(seen)
        remembered, hidden = layers.forward(network, memory, figures)
        logits = layers.head(network["out"], hidden)
        chosen = self.policy.choose(jnp.where(mask, jnp.moveaxis(logits, -1, 0), -jnp.inf), _clock(state, arena))
        after, reward, outcome = swarm.act(self.policy.numbers(chosen, seen), seen, self.physics)
        mask = _agents_first(mask)
        likely = objective.log_probabilities(logits, mask)
        running, going = seen.view.running, self.physics.task.going_on(after, arena, self.physics.swarm)
        noted = Steps(
            figures=figures,
            mask=mask,
            memory=memory,
            action=chosen.astype(jnp.int32),
            log_probability=jnp.take_along_axis(likely, chosen[..., None], axis=-1)[..., 0],
            value=layers.head(value, hidden)[..., 0],
            reward=jnp.where(outcome.intent.acts & running, reward, np.float32(0)),
            able=_able(seen),
            running=running,
            terminated=running & ~going,
            over=~running | ~going | (after.t >= arena.time_limit),
        )
        return (after, remembered), noted


def _agents_first(of_agents: jax.Array) -> jax.Array:
    """[X, n, B] as [n, B, X]."""
    return jnp.moveaxis(of_agents, 0, -1)


def _able(seen: Observation) -> jax.Array:
    return jnp.broadcast_to(seen.view.able, seen.view.x.shape)


def _clock(state: State, arena: Arena) -> Clock:
    """As `episode.clock`, without what only rules look at."""
    return Clock(state.key, state.t, jnp.zeros_like(arena.sink_x))
