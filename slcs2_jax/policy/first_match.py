"""A decision list as a policy: of its rules the first that holds acts (paper, section Human-designed Comparisons).

If none holds, the agent does nothing. Nothing is learnt and nothing is drawn. `decision_list` reads such lists from
text.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.matching import match_set
from slcs2_jax.policy.policy import Clock, Figures, Policy
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm.observation import Observation

_ACTION_BITS = 8  # of a ticket
_NOTHING = np.int32(2**31 - 1)


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
    ticket = jnp.where(match, (order << _ACTION_BITS) | action.astype(jnp.int32), _NOTHING)
    first = jnp.min(ticket, axis=0)
    chosen = jnp.where(first < _NOTHING, first & np.int32(2**_ACTION_BITS - 1), np.int32(NO_ACTION))
    return match & (ticket == first), chosen


@dataclasses.dataclass(frozen=True)
class FirstMatch(Policy):
    """The first rule that holds acts. Parameters: `Rules`; memory: int32 [R, n, ...], steps in which a rule acted."""

    def arrays(self, given: RuleSets, language: Language) -> Rules:
        """Rule-sets, compiled."""
        return Rules.of(given, language)

    def initial_memory(self, parameters: Rules, agents: jax.Array, learning: LearningParameters) -> jax.Array:
        """No rule has acted."""
        xp = parameters.action.__array_namespace__()  # NumPy or JAX
        return xp.zeros(parameters.action.shape, xp.int32)

    def decide(
        self, memory: jax.Array, parameters: Rules, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> tuple[jax.Array, jax.Array]:
        """The action of the first rule that holds."""
        acts, action = first_match(self.matched(parameters, seen), parameters.action)
        return memory + acts.astype(jnp.int32), action

    def finish(self, memory: jax.Array, last_share: jax.Array, learning: LearningParameters) -> Figures:
        """How often each rule acted; nothing is learnt, so the rest is 0."""
        xp = memory.__array_namespace__()
        nothing = xp.zeros(memory.shape, xp.float32)
        return Figures(quality=nothing, strength=nothing, error=nothing, usage=memory)

    def chosen(
        self, memory: jax.Array, parameters: Rules, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> jax.Array:
        """The first rule that holds: int32 [n, ...]; -1 if none does."""
        match = self.matched(parameters, seen)
        return jnp.where(jnp.any(match, axis=0), jnp.argmax(match, axis=0).astype(jnp.int32), np.int32(-1))

    def matched(self, parameters: Rules, seen: Observation) -> jax.Array:
        """The rules that hold: bool [R, n, ...]."""
        return match_set(parameters.mask, seen.truth)
