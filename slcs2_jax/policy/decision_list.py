"""A behaviour made by hand: if-then-else over the vocabulary (paper, section Human-designed Comparisons).

The rules are an ordered list. In each step the first one whose condition holds acts; if none does, the agent does
nothing. Nothing is learnt and nothing is drawn. ``behaviour`` reads such lists from text.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.policy.classifier import Rules
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.matching import match_set

ACTION_BITS = 8
NOTHING = np.int32(2**31 - 1)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Memory:
    """usage: int32 [R, n, ...], time-steps in which the rule acted. All other figures of a rule are 0."""

    usage: jax.Array

    @property
    def quality(self) -> jax.Array:
        """No quality is learnt: float32 [R, n, ...], 0."""
        return jnp.zeros(self.usage.shape, jnp.float32)

    @property
    def strength(self) -> jax.Array:
        """No strength is credited: float32 [R, n, ...], 0."""
        return self.quality

    @property
    def error(self) -> jax.Array:
        """Nothing is predicted: float32 [R, n, ...], 0."""
        return self.quality


def initial_memory(rules: Rules, learning: LearningParameters) -> Memory:
    """No rule has acted."""
    return Memory(jnp.zeros(rules.action.shape, jnp.int32))


def first_match(match: jax.Array, action: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The first rule that holds.

    Args:
        match: bool [R, n, ...].
        action: uint8 [R, n, ...].

    Returns:
        Whether a rule is the one that acts, bool [R, n, ...], and its action, int32 [n, ...]; ``NO_ACTION`` if no rule
        holds.
    """
    order = np.arange(match.shape[0], dtype=np.int32).reshape(-1, *(1,) * (match.ndim - 1))
    # one minimum both finds the rule and tells what it does
    ticket = jnp.where(match, (order << ACTION_BITS) | action.astype(jnp.int32), NOTHING)
    first = jnp.min(ticket, axis=0)
    chosen = jnp.where(first < NOTHING, first & np.int32(2**ACTION_BITS - 1), np.int32(NO_ACTION))
    return match & (ticket == first), chosen


def decide(
    memory: Memory,
    rules: Rules,
    truth: jax.Array,
    key: jax.Array,
    t: jax.Array,
    share: jax.Array,
    learning: LearningParameters,
) -> tuple[Memory, jax.Array]:
    """The action of the first rule that holds; arguments and results as ``Controller.decide`` says."""
    acts, action = first_match(match_set(rules.mask, truth), rules.action)
    return Memory(memory.usage + acts.astype(jnp.int32)), action


def chosen(
    memory: Memory, rules: Rules, truth: jax.Array, key: jax.Array, t: jax.Array, learning: LearningParameters
) -> jax.Array:
    """The first rule that holds: int32 [n, ...]; -1 if none does."""
    match = match_set(rules.mask, truth)
    return jnp.where(jnp.any(match, axis=0), jnp.argmax(match, axis=0).astype(jnp.int32), np.int32(-1))


def remember(memory: Memory, reward: jax.Array) -> Memory:
    """Rewards change nothing."""
    return memory


def gain(reward: jax.Array, acts: jax.Array) -> None:
    """Nothing is credited."""


def settle(memory: Memory, gains: None, learning: LearningParameters) -> Memory:
    """Nothing is credited."""
    return memory


def finish(memory: Memory, share: jax.Array, learning: LearningParameters) -> Memory:
    """The memory itself."""
    return memory
