"""A network as a policy: a pure function of figures and a carry, with a pytree of parameters that all agents share."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar import Grammar
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.policy import Clock, Policy
from slcs2_jax.swarm.action_mask import action_mask
from slcs2_jax.swarm.observation import Observation, features
from slcs2_jax.world import randomness

Apply = Callable[[Any, jax.Array, jax.Array], tuple[jax.Array, jax.Array]]


@dataclasses.dataclass(frozen=True)
class Network(Policy):
    """An agent's action is the one with the greatest logit among those that could have an effect, or is drawn by them.

    Attributes:
        apply: (parameters, carry [C], features [F]) -> carry [C], logits [A + 1], of one agent; the last logit is to do
            nothing. The features are those of `swarm.observation.features`.
        actions: numbers of the A actions.
        language: what the agents can say and do.
        carry: C, what an agent remembers from step to step, zero at first; 0 for a network without memory.
        sample: draw by the logits, in place of the greatest.
        channel_places: indices of the channels that the actions use.
    """

    apply: Apply
    actions: tuple[int, ...]
    language: Language
    carry: int = 0
    sample: bool = False
    channel_places: tuple[int, ...] = (0,)

    @classmethod
    def over(cls, grammar: Grammar, apply: Apply, *, carry: int = 0, sample: bool = False) -> Network:
        """A network that takes the actions of a grammar, in its order, as an environment of that grammar does."""
        return cls(apply, grammar.actions, Language.of([grammar]), carry, sample, grammar.channels_used)

    @property
    def channels(self) -> tuple[int, ...]:
        """Indices of the channels that the agents use."""
        return self.channel_places

    def initial_memory(self, parameters: Any, agents: jax.Array, learning: LearningParameters) -> jax.Array:
        """Nothing remembered: float32 [C, n, ...]."""
        return jnp.zeros((self.carry, *agents.shape), jnp.float32)

    def decide(
        self, memory: jax.Array, parameters: Any, seen: Observation, clock: Clock, learning: LearningParameters
    ) -> tuple[jax.Array, jax.Array]:
        """The carry float32 [C, n, ...], and the actions int32 [n, ...]."""
        each = jax.vmap(self.apply, in_axes=(None, -1, -1), out_axes=-1)  # over agents, which share the parameters
        for _ in clock.t.shape:
            each = jax.vmap(each, in_axes=-1, out_axes=-1)  # over the batch
        carry, logits = each(parameters, memory, self.figures(seen))
        chosen = self.choose(jnp.where(self.mask(seen), logits, -jnp.inf), clock)
        return carry, self.numbers(chosen, seen)

    def figures(self, seen: Observation) -> jax.Array:
        """What the network looks at: float32 [F, n, ...], whatever other channels the batch may have."""
        return features(seen.view, 1 + max(self.channel_places))

    def mask(self, seen: Observation) -> jax.Array:
        """Which actions could have an effect now, and last to do nothing, which always can: bool [A + 1, n, ...]."""
        mask = action_mask(seen.view, self.actions, self.language)
        return jnp.concatenate([mask, jnp.ones_like(mask[:1])])

    def choose(self, logits: jax.Array, clock: Clock) -> jax.Array:
        """The place of the action that is taken: int32 [n, ...]; logits float32 [A + 1, n, ...], -inf where masked."""
        if self.sample:
            number = np.arange(logits.shape[0] * logits.shape[1], dtype=np.uint32)
            number = number.reshape(*logits.shape[:2], *(1,) * clock.t.ndim)
            words = randomness.bits(randomness.stream(clock.key, clock.t, randomness.Purpose.POLICY), number)
            uniform = ((words >> np.uint32(8)).astype(jnp.float32) + np.float32(0.5)) * np.float32(2**-24)
            logits = logits - jnp.log(-jnp.log(uniform))  # Gumbel's: the greatest is drawn in proportion
        return jnp.argmax(logits, axis=0)

    def numbers(self, chosen: jax.Array, seen: Observation) -> jax.Array:
        """The vocabulary's numbers of the places in `choose`: int32 [n, ...]."""
        known = np.array([*self.actions, NO_ACTION], np.int32)
        return jnp.where(seen.view.running, jnp.asarray(known)[chosen], np.int32(NO_ACTION))
