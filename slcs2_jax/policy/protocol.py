"""What an episode asks of a controller: a few pure functions. A module of such functions is a controller."""

from __future__ import annotations

from typing import Any, Protocol

import jax

from slcs2_jax.policy.classifier import Rules
from slcs2_jax.policy.learning import LearningParameters


class Controller(Protocol):
    """What an agent does with what it sees: ``classifier``, ``designed``, or a module or object of your own.

    All functions are traced once and work on a single instance as on a batch, whose axis is the last. The memory is
    the controller's own: any pytree of arrays whose last axis is the batch. R rules, n agents, W words of clauses. A
    controller is part of compiled programs, so it must be hashable and never change.
    """

    def initial_memory(self, rules: Rules, learning: LearningParameters) -> Any:
        """The memory of agents that have seen nothing."""

    def decide(
        self,
        memory: Any,
        rules: Rules,
        truth: jax.Array,
        key: jax.Array,
        t: jax.Array,
        share: jax.Array,
        learning: LearningParameters,
    ) -> tuple[Any, jax.Array]:
        """The memory, and each agent's action, int32 [n, ...], of the vocabulary; ``NO_ACTION`` for none.

        Args:
            memory: from the step before.
            rules: what was deployed, the same throughout the episode.
            truth: uint32 [>= W, n, ...], the clauses that are true; none once the episode is over.
            key, t: uint32 [2, ...] and int32 [...], the episode's key and the step, for draws.
            share: float32 [...], share of the time limit at which the last action was taken.
            learning: parameters.
        """

    def chosen(
        self,
        memory: Any,
        rules: Rules,
        truth: jax.Array,
        key: jax.Array,
        t: jax.Array,
        learning: LearningParameters,
    ) -> jax.Array:
        """For recordings: which rule made `decide` return this memory and its action, int32 [n, ...]; -1 for none."""

    def remember(self, memory: Any, reward: jax.Array) -> Any:
        """Take the reward of the action just taken, float32 [n, ...]."""

    def gain(self, reward: jax.Array, acts: jax.Array) -> Any:
        """What to keep of a step for ``settle``: arrays [n, ...] or None; acts: bool [n, ...], who acted."""

    def settle(self, memory: Any, gains: Any, learning: LearningParameters) -> Any:
        """After a round of L steps; gains: what ``gain`` returned, stacked, [L, n, ...]."""

    def finish(self, memory: Any, share: jax.Array, learning: LearningParameters) -> Figures:
        """The figures of an episode that is over; between rounds, and at any time after the end the same."""


class Figures(Protocol):
    """Per rule and agent, [R, n, ...]: float32 quality, strength (divided by usage), error; int32 usage."""

    @property
    def quality(self) -> jax.Array: ...

    @property
    def strength(self) -> jax.Array: ...

    @property
    def error(self) -> jax.Array: ...

    @property
    def usage(self) -> jax.Array: ...
