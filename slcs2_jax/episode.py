"""An episode on the device: agents in their world, step after step, for any number of instances at once.

Pure functions of arrays whose last axis is the batch. ``rollout`` drives them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import chex
import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.settings import Settings
from slcs2_jax.policy import classifier, strength
from slcs2_jax.policy.classifier import Rules
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.protocol import Controller
from slcs2_jax.swarm import knowledge
from slcs2_jax.swarm import step as world
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.state import State, running
from slcs2_jax.swarm.step import Outcome, Physics
from slcs2_jax.world.arena import Arena


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Parameters:
    """What episodes have in common; leaves are scalars, the sharing period gives shapes, the controller is code."""

    physics: Physics
    learning: LearningParameters
    sharing_period: int = dataclasses.field(metadata={"static": True})
    controller: Controller = dataclasses.field(default=classifier, metadata={"static": True})

    @classmethod
    def of(cls, settings: Settings, controller: Controller = classifier) -> Parameters:
        """Take the values from the settings; ``controller`` says what the agents do with what they see."""
        learning = LearningParameters.of(settings.learning)
        return cls(Physics.of(settings), learning, settings.swarm.sharing_period, controller)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Episode:
    """An episode under way: what is given, and what has become of it; ``memory`` is the controller's."""

    arena: Arena
    rules: Rules
    state: State
    memory: Any


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Result:
    """An episode's figures (spec section 7), strength already divided by usage.

    Attributes:
        steps, delivered: int32 [...], T_s and p_s.
        contribution: int32 [n, ...].
        quality, strength, error: float32 [R, n, ...].
        usage: int32 [R, n, ...].
    """

    steps: jax.Array
    delivered: jax.Array
    contribution: jax.Array
    quality: jax.Array
    strength: jax.Array
    error: jax.Array
    usage: jax.Array


def begin(arena: Arena, rules: Rules, key: jax.Array, parameters: Parameters) -> Episode:
    """Deploy the swarm: key uint32 [2, ...]. Shapes and types that do not fit raise AssertionError."""
    agents = arena.start_x.shape
    chex.assert_shape(key, (2, *agents[1:]))
    chex.assert_shape(rules.action, (None, *agents))
    chex.assert_shape(rules.mask, (None, *rules.action.shape))
    chex.assert_type([key, rules.mask, rules.action, arena.start_x], [np.uint32, np.uint32, np.uint8, np.float32])
    state = world.begin(arena, key, parameters.physics)
    return Episode(arena, rules, state, parameters.controller.initial_memory(rules, parameters.learning))


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Moment:
    """A time-step in full, for those who look on: what agents saw, over which links, what they did, what it brought.

    action: int32 [n, ...], numbers of the vocabulary; `NO_ACTION` for none.
    """

    seen: Observation
    drawn: Links
    action: jax.Array
    outcome: Outcome


def step(episode: Episode, parameters: Parameters) -> tuple[Episode, Moment]:
    """One time-step of one episode or of a batch."""
    physics = parameters.physics
    state, drawn, seen = world.observe(episode.state, episode.arena, physics)
    memory, action = parameters.controller.decide(
        episode.memory, episode.rules, seen.truth, state.key, state.t, _last_share(episode), parameters.learning
    )
    state, outcome = world.act(state, action, seen, drawn, episode.arena, physics)
    memory = parameters.controller.remember(memory, outcome.reward)
    return dataclasses.replace(episode, state=state, memory=memory), Moment(seen, drawn, action, outcome)


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
    controller = parameters.controller

    def one_step(before: Episode, _: None) -> tuple[Episode, Any]:
        episode, moment = step(before, parameters)
        gain = controller.gain(moment.outcome.reward, moment.outcome.acts)
        return episode, (gain, note(before, episode, moment))

    def one_round(episode: Episode, _: None) -> tuple[Episode, Any]:
        episode, (gains, notes) = jax.lax.scan(one_step, episode, length=length)
        memory = controller.settle(episode.memory, gains, parameters.learning)
        return dataclasses.replace(episode, memory=memory), notes

    def one_period(episode: Episode, _: None) -> tuple[Episode, Any]:
        episode, notes = jax.lax.scan(one_round, episode, length=parameters.sharing_period // length)
        return dataclasses.replace(episode, state=knowledge.share(episode.state)), notes

    return jax.lax.scan(one_period, episode, length=periods)


def result(episode: Episode, parameters: Parameters) -> Result:
    """The figures of an episode, meaningful once it is over."""
    memory = parameters.controller.finish(episode.memory, _last_share(episode), parameters.learning)
    state = episode.state
    return Result(
        steps=state.t,
        delivered=state.delivered,
        contribution=state.contribution,
        quality=memory.quality,
        strength=memory.strength,
        error=memory.error,
        usage=memory.usage,
    )


def over(episode: Episode, parameters: Parameters) -> jax.Array:
    """Whether each episode has ended: bool [...]."""
    return ~running(episode.state, episode.arena, parameters.physics.swarm)


def _last_share(episode: Episode) -> jax.Array:
    """Share of the time limit at which the last step was taken: float32 [...]."""
    last = (episode.state.t - np.int32(1)).astype(jnp.float32)
    return jnp.maximum(last, np.float32(0)) / jnp.maximum(episode.arena.time_limit, np.int32(1)).astype(jnp.float32)
