"""The rule-set classifier: match, learn, choose, remember (spec section 6)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.policy import grasp, matching, qlearning, strength
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.strength import gain as gain  # a part of the interface: see ``controller``
from slcs2_jax.world import randomness
from slcs2_jax.world.stored import stored


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Rules:
    """Compiled rules. mask: uint32 [W, R, n, ...], clauses; action: uint8 [R, n, ...]."""

    mask: jax.Array
    action: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Memory:
    """What an agent has learnt in this episode.

    Attributes:
        quality: float32 [R, n, ...], q.
        error: float32 [R, n, ...], epsilon.
        strength: float32 [R, n, ...], zeta before the division by usage.
        usage: int32 [R, n, ...], tau.
        trace: uint32 [R, n, ...], bit k tells whether the rule was in the action set k steps ago.
        reward: float32 [n, ...], rho of the last action.
        recent: float32 [BP_max, n, ...], the last gains, the latest first.
    """

    quality: jax.Array
    error: jax.Array
    strength: jax.Array
    usage: jax.Array
    trace: jax.Array
    reward: jax.Array
    recent: jax.Array


def initial_memory(rules: Rules, learning: LearningParameters) -> Memory:
    """Nothing learnt: all zero (spec 6)."""
    per_agent = rules.action.shape[1:]
    zeros = jnp.zeros(rules.action.shape, jnp.float32)
    return Memory(
        quality=zeros,
        error=zeros,
        strength=zeros,
        usage=jnp.zeros(zeros.shape, jnp.int32),
        trace=jnp.zeros(zeros.shape, jnp.uint32),
        reward=jnp.zeros(per_agent, jnp.float32),
        recent=jnp.zeros((learning.bp_max, *per_agent), jnp.float32),
    )


def decide(
    memory: Memory,
    rules: Rules,
    truth: jax.Array,
    key: jax.Array,
    t: jax.Array,
    share: jax.Array,
    learning: LearningParameters,
) -> tuple[Memory, jax.Array]:
    """Learn from the last step, then choose.

    Args:
        memory, rules: the agents'.
        truth: uint32 [>= W, n, ...], true clauses.
        key, t: uint32 [2, ...] and int32 [...], for the draw.
        share: float32 [...], share of the time limit at which the last action was taken, for the schedule of alpha_q.
        learning: parameters.

    Returns:
        The memory with the new action set, and the action int32 [n, ...].
    """
    match = matching.match_set(rules.mask, truth)
    quality, error = _learn(memory, qlearning.best_ahead(memory.quality, match), share, learning)
    action = grasp.choose(match, quality, rules.action, _lots(rules, key, t, learning), learning.alpha_grasp)
    members = match & (rules.action == action.astype(jnp.uint8))
    trace = (memory.trace << np.uint32(1)) | members.astype(jnp.uint32)
    return dataclasses.replace(memory, quality=quality, error=error, trace=trace), action


def chosen(
    memory: Memory, rules: Rules, truth: jax.Array, key: jax.Array, t: jax.Array, learning: LearningParameters
) -> jax.Array:
    """The rule that ``decide`` drew when it returned this memory: int32 [n, ...]; -1 where nothing matched."""
    match = matching.match_set(rules.mask, truth)
    lots = _lots(rules, key, t, learning)
    return grasp.chosen(match, memory.quality, rules.action, lots, learning.alpha_grasp)


def _lots(rules: Rules, key: jax.Array, t: jax.Array, learning: LearningParameters) -> jax.Array:
    """A uniform word for every rule and step: uint32 [R, n, ...]."""
    count, n = rules.action.shape[:2]
    number = np.arange(count * n, dtype=np.uint32).reshape(count, n, *(1,) * t.ndim)
    return randomness.bits(stored(randomness.stream(key, t, randomness.Purpose.RULE), learning.beta_q), number)


def remember(memory: Memory, reward: jax.Array) -> Memory:
    """Keep the reward of the action just taken, float32 [n, ...], to learn from when the next step is seen."""
    return dataclasses.replace(memory, reward=reward)


def settle(memory: Memory, gains: jax.Array, learning: LearningParameters) -> Memory:
    """Credit strength and usage after a round: see ``strength.settle``; gains float32 [L, n, ...]."""
    total, usage, recent = strength.settle(
        memory.strength, memory.usage, memory.trace, memory.recent, gains, learning.trace_decay
    )
    return dataclasses.replace(memory, strength=total, usage=usage, recent=recent)


def finish(memory: Memory, share: jax.Array, learning: LearningParameters) -> Memory:
    """The memory of an episode that is over: last action learnt with nothing ahead, strength divided by usage.

    Call it between rounds. Calling it later than the first round after the end changes nothing.
    """
    quality, error = _learn(memory, jnp.zeros_like(memory.reward), share, learning)
    settled = strength.finish(memory.strength, memory.usage, memory.trace, memory.recent, learning.trace_decay)
    return dataclasses.replace(memory, quality=quality, error=error, strength=settled)


def _learn(
    memory: Memory, ahead: jax.Array, share: jax.Array, learning: LearningParameters
) -> tuple[jax.Array, jax.Array]:
    members = (memory.trace & np.uint32(1)) == np.uint32(1)
    alpha = learning.alpha(share)
    return qlearning.update(memory.quality, memory.error, members, memory.reward, ahead, alpha, learning.beta_q)
