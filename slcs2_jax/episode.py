"""An episode on the device: agents in their world, step after step, for any number of instances at once.

Pure functions of arrays whose last axis is the batch. ``rollout`` drives them in bulk, ``env`` one step at a time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable
from typing import Any

import chex
import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.settings import Settings
from slcs2_jax.grammar.language import Language
from slcs2_jax.policy import strength
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.policy import Clock, Figures, Policy, decided
from slcs2_jax.swarm import knowledge
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.outcome import Outcome
from slcs2_jax.swarm.state import State
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import Arena


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Parameters:
    """What episodes have in common; leaves are scalars, the sharing period gives shapes, the policy is code."""

    physics: Physics
    learning: LearningParameters
    sharing_period: int = dataclasses.field(metadata={"static": True})
    policy: Policy = dataclasses.field(default=Classifier(), metadata={"static": True})

    @classmethod
    def of(cls, settings: Settings, policy: Policy | None = None, language: Language | None = None) -> Parameters:
        """Take the values from the settings.

        Args:
            settings: of the run.
            policy: what the agents do with what they see; by default the classifier.
            language: what they can say and do; by default the paper's vocabulary.
        """
        learning = LearningParameters.of(settings.learning)
        physics = Physics.of(settings, language)
        return cls(physics, learning, settings.swarm.sharing_period, policy or Classifier())


def physical(settings: Settings) -> Hashable:
    """What of the settings `Parameters` are made of."""
    return (settings.radio, settings.swarm, settings.learning, settings.task, settings.world.wall_thickness)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Episode:
    """An episode under way: what is given, and what has become of it.

    `given` are the policy's parameters, and `memory` is the policy's own.
    """

    arena: Arena
    given: Any
    state: State
    memory: Any


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Result:
    """What an episode came to.

    Attributes:
        steps, delivered: int32 [...], T_s and p_s.
        contribution: int32 [n, ...].
        figures: [R, n, ...], what rules have learnt; None for a policy without rules.
        measures: what the task takes from the last state, by name.
    """

    steps: jax.Array
    delivered: jax.Array
    contribution: jax.Array
    figures: Figures | None
    measures: dict[str, jax.Array]


def begin(arena: Arena, given: Any, key: jax.Array, parameters: Parameters) -> Episode:
    """Deploy the swarm: key uint32 [2, ...]. Shapes and types that do not fit raise AssertionError."""
    agents = arena.start_x.shape
    chex.assert_shape(key, (2, *agents[1:]))
    chex.assert_type([key, arena.start_x], [np.uint32, np.float32])
    state = swarm.begin(arena, key, parameters.physics)
    memory = parameters.policy.initial_memory(given, arena.start_x, parameters.learning)
    return Episode(arena, given, state, memory)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Moment:
    """A time-step in full, for those who look on: what agents saw, what they did, what it brought.

    action: int32 [n, ...], numbers of the vocabulary; `NO_ACTION` for none. reward: float32 [n, ...], meaningless for
    agents that did not act.
    """

    seen: Observation
    action: jax.Array
    reward: jax.Array
    outcome: Outcome


def step(episode: Episode, parameters: Parameters) -> tuple[Episode, Moment]:
    """One time-step of one episode or of a batch."""
    physics, policy = parameters.physics, parameters.policy
    state, seen = swarm.observe(episode.state, episode.arena, physics)
    memory, action = decided(policy, episode.memory, episode.given, seen, clock(episode), parameters.learning)
    state, reward, outcome = swarm.act(action, seen, physics)
    memory = policy.remember(memory, reward)
    return dataclasses.replace(episode, state=state, memory=memory), Moment(seen, action, reward, outcome)


def advance(episode: Episode, parameters: Parameters, periods: int) -> Episode:
    """Some sharing periods of steps; episodes that are over stand still."""
    return watch(episode, parameters, periods, lambda *_: None)[0]


def watch(
    episode: Episode, parameters: Parameters, periods: int, note: Callable[[Episode, Episode, Moment], Any]
) -> tuple[Episode, Any]:
    """`advance`, and what `note` makes of every step: of the episode before and after it and of the moment itself.

    Returns:
        The episode, and the notes stacked, [periods, rounds, L, ...] with the product of the three the steps.
    """
    length = strength.round_length(parameters.sharing_period, parameters.learning.bp_max)
    policy = parameters.policy

    def one_step(before: Episode, _: None) -> tuple[Episode, Any]:
        episode, moment = step(before, parameters)
        kept = policy.keep(episode.memory, moment.reward, moment.outcome.intent.acts)
        return episode, (kept, note(before, episode, moment))

    def one_round(episode: Episode, _: None) -> tuple[Episode, Any]:
        episode, (kept, notes) = jax.lax.scan(one_step, episode, length=length)
        memory = policy.settle(episode.memory, kept, parameters.learning)
        return dataclasses.replace(episode, memory=memory), notes

    def one_period(episode: Episode, _: None) -> tuple[Episode, Any]:
        episode, notes = jax.lax.scan(one_round, episode, length=parameters.sharing_period // length)
        return dataclasses.replace(episode, state=knowledge.share(episode.state)), notes

    return jax.lax.scan(one_period, episode, length=periods)


def result(episode: Episode, parameters: Parameters) -> Result:
    """What an episode came to, meaningful once it is over."""
    state = episode.state
    return Result(
        steps=state.t,
        delivered=state.delivered,
        contribution=state.contribution,
        figures=parameters.policy.finish(episode.memory, clock(episode).last_share, parameters.learning),
        measures=parameters.physics.task.measure(state, episode.arena),
    )


def over(episode: Episode, parameters: Parameters) -> jax.Array:
    """Whether each episode has ended: bool [...]."""
    physics = parameters.physics
    return ~physics.task.running(episode.state, episode.arena, physics.swarm)


def clock(episode: Episode) -> Clock:
    """When the decision of the step to come is taken."""
    state = episode.state
    last = (state.t - np.int32(1)).astype(jnp.float32)
    limit = jnp.maximum(episode.arena.time_limit, np.int32(1)).astype(jnp.float32)
    return Clock(state.key, state.t, jnp.maximum(last, np.float32(0)) / limit)
