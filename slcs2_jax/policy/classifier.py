"""The rule-set classifier: match, learn, choose, remember (paper, sections on rule choice and learning)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.policy import bits, grasp, matching, qlearning, strength
from slcs2_jax.policy.first_match import first_match
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.policy import Clock, Figures, Policy
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.world import randomness
from slcs2_jax.world.stored import stored


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Memory:
    """What an agent has learnt in this episode.

    Attributes:
        quality: float32 [R, n, ...], q.
        error: float32 [R, n, ...], epsilon.
        strength: float32 [R, n, ...], zeta before the division by usage.
        usage: int32 [R, n, ...], tau.
        trace: uint32 [R, n, ...], bit k tells whether the rule was in the action set k steps ago, as of the last round.
        members: uint32 [W, n, ...], the last action set, as `bits`.
        reward: float32 [n, ...], rho of the last action.
        recent: float32 [BP_max, n, ...], the last gains, as of the last round, the latest first.
    """

    quality: jax.Array
    error: jax.Array
    strength: jax.Array
    usage: jax.Array
    trace: jax.Array
    members: jax.Array
    reward: jax.Array
    recent: jax.Array


@dataclasses.dataclass(frozen=True)
class Classifier(Policy):
    """The paper's agent: GRASP over learnt quality, Q-learning, a bounded trace of strength. Parameters: `Rules`.

    Beyond the paper, rules may be reflexes (subsumption; Brooks 1986): the first flagged rule that holds acts, before
    any choice; learning sees its action set as any other.
    """

    def arrays(self, given: RuleSets, language: Language) -> Rules:
        """Rule-sets, compiled."""
        return Rules.of(given, language)

    def initial_memory(self, parameters: Rules, agents: jax.Array, learning: LearningParameters) -> Memory:
        """Nothing learnt: all zero, but for quality that the rules bring, or that the settings give to all."""
        xp = parameters.action.__array_namespace__()  # NumPy or JAX
        rules, *per_agent = parameters.action.shape
        zeros = xp.zeros(parameters.action.shape, xp.float32)
        return Memory(
            quality=zeros + learning.initial_quality if parameters.quality is None else parameters.quality,
            error=zeros,
            strength=zeros,
            usage=xp.zeros(zeros.shape, xp.int32),
            trace=xp.zeros(zeros.shape, xp.uint32),
            members=xp.zeros((bits.words(rules), *per_agent), xp.uint32),
            reward=xp.zeros(per_agent, xp.float32),
            recent=xp.zeros((learning.bp_max, *per_agent), xp.float32),
        )

    def decide(
        self, memory: Memory, parameters: Rules, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> tuple[Memory, jax.Array]:
        """Learn from the last step, then choose: the memory with the new action set, and the action int32 [n, ...]."""
        match = self.matched(parameters, seen)
        ahead = qlearning.best_ahead(memory.quality, match)
        quality, error = _learn(memory, ahead, clock.last_share, learning)
        lots = _lots(parameters, clock, learning)
        action = grasp.choose(match, quality, parameters.action, lots, learning.alpha_grasp)
        if parameters.reflex is not None:
            _, reflex = first_match(match & parameters.reflex, parameters.action)
            action = jnp.where(reflex == NO_ACTION, action, reflex)
        members = stored(match & (parameters.action == action.astype(jnp.uint8)), learning.beta_q)
        return dataclasses.replace(memory, quality=quality, error=error, members=bits.pack(members)), action

    def remember(self, memory: Memory, reward: jax.Array) -> Memory:
        """Keep the reward of the action just taken, to learn from when the next step is seen."""
        return dataclasses.replace(memory, reward=reward)

    def keep(self, memory: Memory, reward: jax.Array, acts: jax.Array) -> tuple[jax.Array, jax.Array]:
        """The action set, uint32 [W, n, ...], and the gain, float32 [n, ...], see `strength.gain`."""
        # Who does not act has an empty set anyway; but a mere copy of it would break up a GPU's graph of a chunk.
        members = jnp.where(acts, memory.members, np.uint32(0))
        return members, strength.gain(reward, acts)

    def settle(self, memory: Memory, kept: tuple[jax.Array, jax.Array], learning: LearningParameters) -> Memory:
        """Credit strength and usage after a round: see `strength.settle`."""
        total, usage, trace, recent = strength.settle(
            memory.strength, memory.usage, memory.trace, memory.recent, *kept, learning.trace_decay
        )
        return dataclasses.replace(memory, strength=total, usage=usage, trace=trace, recent=recent)

    def finish(self, memory: Memory, last_share: jax.Array, learning: LearningParameters) -> Figures:
        """The last action learnt with nothing ahead, strength divided by usage.

        Call it between rounds. Calling it later than the first round after the end changes nothing.
        """
        quality, error = _learn(memory, jnp.zeros_like(memory.reward), last_share, learning)
        settled = strength.finish(memory.strength, memory.usage, memory.trace, memory.recent, learning.trace_decay)
        return Figures(quality=quality, strength=settled, error=error, usage=memory.usage)

    def chosen(
        self, memory: Memory, parameters: Rules, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> jax.Array:
        """The rule that `decide` drew when it returned this memory: int32 [n, ...]; -1 where nothing matched."""
        lots = _lots(parameters, clock, learning)
        match = self.matched(parameters, seen)
        drawn = grasp.chosen(match, memory.quality, parameters.action, lots, learning.alpha_grasp)
        if parameters.reflex is None:
            return drawn
        flagged = match & parameters.reflex
        return jnp.where(jnp.any(flagged, axis=0), jnp.argmax(flagged, axis=0).astype(jnp.int32), drawn)

    def matched(self, parameters: Rules, seen: Observation) -> jax.Array:
        """The match set: bool [R, n, ...]."""
        return matching.match_set(parameters.mask, seen.truth)


def _lots(rules: Rules, clock: Clock, learning: LearningParameters) -> jax.Array:
    """A uniform word for every rule and step: uint32 [R, n, ...]."""
    count, n = rules.action.shape[:2]
    number = np.arange(count * n, dtype=np.uint32).reshape(count, n, *(1,) * clock.t.ndim)
    stream = randomness.stream(clock.key, clock.t, randomness.Purpose.RULE)
    return randomness.bits(stored(stream, learning.beta_q), number)


def _learn(
    memory: Memory, ahead: jax.Array, share: jax.Array, learning: LearningParameters
) -> tuple[jax.Array, jax.Array]:
    members = bits.unpack(memory.members, memory.quality.shape[0])
    alpha = learning.alpha(share)
    return qlearning.update(memory.quality, memory.error, members, memory.reward, ahead, alpha, learning.beta_q)
