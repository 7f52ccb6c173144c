"""What an episode asks of a policy: an initial memory, and a decision in every step. Whatever decides is a policy."""

from __future__ import annotations

import abc
import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.language import Language
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.view import checked


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Clock:
    """When a decision is taken, and what it may draw from.

    Attributes:
        key: uint32 [2, ...], the episode's key.
        t: int32 [...], the time-step.
        last_share: float32 [...], share of the time limit at which the last action was taken.
    """

    key: jax.Array
    t: jax.Array
    last_share: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Figures:
    """What rules have learnt, [R, n, ...] on the device, [n, R] on the host.

    Attributes:
        quality: float32, q.
        strength: float32, zeta, divided by usage once an episode is over.
        error: float32, epsilon.
        usage: int32, tau.
    """

    quality: Any
    strength: Any
    error: Any
    usage: Any


class Policy(abc.ABC):
    """What an agent does with what it sees. Derive from it, and register, for one of your own.

    A policy's parameters are any pytree of arrays; the batch, if any, is the last axis of every leaf, and no function
    names it. All methods are traced once and are pure. A policy is part of compiled programs, so it must be hashable
    and never change: a frozen dataclass, or a plain object of a class without attributes.
    """

    @classmethod
    def of(cls, given: Any) -> Policy:
        """The policy of a name for these parameters; to be overridden where they say more than its arrays hold, such as
        what its actions are. Raises InputError for parameters that are none of it."""
        return cls()

    @property
    def channels(self) -> tuple[int, ...]:
        """Indices of the channels that the agents use."""
        return (0,)

    def arrays(self, given: Any, language: Language) -> Any:
        """The parameters of one deployment as NumPy arrays without a batch axis; `given` is what the user deploys."""
        return given

    @abc.abstractmethod
    def initial_memory(self, parameters: Any, agents: jax.Array, learning: LearningParameters) -> Any:
        """The memory of agents that have seen nothing: any pytree of arrays with the batch last.

        agents: any array [n, ...], for its shape.
        """

    @abc.abstractmethod
    def decide(
        self, memory: Any, parameters: Any, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> tuple[Any, jax.Array]:
        """The memory, and each agent's action, int32 [n, ...], of the vocabulary; ``NO_ACTION`` for none."""

    def remember(self, memory: Any, reward: jax.Array) -> Any:
        """Take the reward of the action just taken, float32 [n, ...]."""
        return memory

    def keep(self, memory: Any, reward: jax.Array, acts: jax.Array) -> Any:
        """What to keep of a step for `settle`: any arrays, or None.

        memory: after `remember`; reward: float32 [n, ...]; acts: bool [n, ...], who acted.
        """
        return None

    def settle(self, memory: Any, kept: Any, learning: LearningParameters) -> Any:
        """After a round of L steps; kept: what `keep` returned, stacked, [L, ...]."""
        return memory

    def finish(self, memory: Any, last_share: jax.Array, learning: LearningParameters) -> Figures | None:
        """What rules have learnt in an episode that is over; None for a policy without rules.

        Called between rounds, and at any time after the end with the same result.
        """
        return None

    def chosen(
        self, memory: Any, parameters: Any, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> jax.Array:
        """For recordings: which rule made `decide` return this memory and its action, int32 [n, ...]; -1 for none."""
        return jnp.full(seen.view.x.shape, np.int32(-1))

    def matched(self, parameters: Any, seen: Observation) -> jax.Array:
        """For recordings: the rules that hold, bool [R, n, ...]; R is 0 for a policy without rules."""
        return jnp.zeros((0, *seen.view.x.shape), bool)


def decided(
    policy: Policy, memory: Any, parameters: Any, seen: Observation, clock: Clock, learning: LearningParameters
) -> tuple[Any, jax.Array]:
    """`decide`, and whether it gave what it should. Raises InputError naming the policy, and what is accepted."""
    name = type(policy).__name__
    found = policy.decide(memory, parameters, seen, clock, learning)
    if not isinstance(found, tuple) or len(found) != 2:
        raise InputError(f"policy {name!r}: decide returned {type(found).__name__}; accepted are a memory and actions")
    after, action = found
    if _form(memory) != _form(after):
        raise InputError(f"policy {name!r}: its memory changes its shape or type; accepted is that of initial_memory")
    return after, checked("policy", name, action, seen.view.x, np.int32)


def _form(tree: Any) -> tuple[Any, ...]:
    """Structure, shapes and types of a pytree."""
    leaves, structure = jax.tree.flatten(tree)
    return structure, [(jnp.shape(leaf), jnp.result_type(leaf)) for leaf in leaves]
