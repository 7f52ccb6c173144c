"""What IPPO changes in an update, and how: one compiled program collects, estimates and learns."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax

from slcs2_jax.learning import objective
from slcs2_jax.learning.advantage import Scale, advantages
from slcs2_jax.learning.collection import Collector, Episodes, Steps
from slcs2_jax.learning.ippo_settings import Ippo
from slcs2_jax.learning.optimiser import stepped
from slcs2_jax.policy import layers

Measures = dict[str, jax.Array]


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Learner:
    """What is learnt.

    Attributes:
        weights: `{"network": see policy.layers, "value": the layer that values are read with}`.
        optimiser: Adam's state.
        scale: of values.
    """

    weights: Any
    optimiser: Any
    scale: Scale


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Data:
    """Sequences to learn from: S of them, L steps long; axes [L, S, ...], but for memory, [1, S, C], before the first.

    As in `Steps`; advantage float32, of mean 0 and deviation 1; target float32, the return in the value's unit.
    """

    figures: jax.Array
    mask: jax.Array
    action: jax.Array
    log_probability: jax.Array
    advantage: jax.Array
    target: jax.Array
    able: jax.Array
    memory: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Update:
    """An update of IPPO: every agent learns from what itself sees and earns, all by one network (de Witt et al. 2020,
    arXiv 2011.09533). Pure code, to be compiled."""

    settings: Ippo = dataclasses.field(metadata={"static": True})
    collector: Collector

    def begin(self, network: Any, value: Any) -> Learner:
        """Of a network and its value layer, nothing learnt."""
        weights = jax.tree.map(jnp.asarray, {"network": network, "value": value})
        return Learner(weights, self._optimiser().init(weights), Scale.new())

    def __call__(
        self, learner: Learner, episodes: Episodes, key: jax.Array, rate: jax.Array
    ) -> tuple[Learner, Episodes, Measures]:
        """Collect, then learn.

        Args:
            learner: see there.
            episodes: see `collection`.
            key: what the order of the data is drawn from.
            rate: float32, the learning rate.

        Returns:
            Both as they are afterwards, and measures: those of `loss`, averaged; reward, the mean of a step of an
            agent; norm, of the weights; steps, int32, env-steps of episodes that were not over; explained, the share of
            the returns' variance that the value explains.
        """
        weights = learner.weights
        episodes, steps, after = self.collector.collect(
            weights["network"], weights["value"], episodes, self.settings.chunk
        )
        data, scale, measures = self._data(steps, after, learner.scale)
        run = partial(self._step, data, rate)
        (weights, optimiser), taken = jax.lax.scan(run, (weights, learner.optimiser), self._order(data, key))
        measures |= jax.tree.map(jnp.mean, taken) | {"norm": _norm(weights)}
        return Learner(weights, optimiser, scale), episodes, measures

    def _optimiser(self) -> Any:
        """Adam's direction: the learning rate changes, and is given."""
        return optax.chain(optax.clip_by_global_norm(self.settings.gradient_norm), optax.adam(1.0, eps=1e-5))

    def _data(self, steps: Steps, after: jax.Array, scale: Scale) -> tuple[Data, Scale, Measures]:
        """What the steps come to as data; the scale with their returns; what they were like."""
        settings, agents = self.settings, steps.reward.shape[1]
        value = scale.real(jnp.concatenate([steps.value, after[None]]))
        every = [jnp.repeat(one[:, None], agents, axis=1) for one in (steps.terminated, steps.over)]
        gained = advantages(steps.reward, value, *every, discount=settings.discount, decay=settings.gae)
        returns, weight = gained + value[:-1], steps.able.astype(jnp.float32)
        error, spread = (objective.mean((x - objective.mean(x, weight)) ** 2, weight) for x in (gained, returns))
        scale = scale.seen(returns, weight, settings.value_decay)
        advantage = (gained - objective.mean(gained, weight)) / (jnp.sqrt(error) + np.float32(1e-8))
        length = settings.unroll if self.collector.policy.carry else 1
        sequences = {name: _sequences(getattr(steps, name), length) for name in ("figures", "mask", "action", "able")}
        data = Data(
            **sequences,
            log_probability=_sequences(steps.log_probability, length),
            advantage=_sequences(advantage, length),
            target=_sequences(scale.scaled(returns), length),
            memory=_sequences(steps.memory[::length], 1),
        )
        measures = {
            "reward": objective.mean(steps.reward, weight),
            "steps": jnp.sum(steps.running, dtype=jnp.int32),
            "explained": np.float32(1) - error / jnp.maximum(spread, np.float32(1e-8)),
        }
        return data, scale, measures

    def _order(self, data: Data, key: jax.Array) -> jax.Array:
        """Which sequences each gradient step looks at: int32 [epochs x minibatches, of each]."""
        settings, count = self.settings, data.memory.shape[1]
        each = max(1, int(count * settings.share) // settings.minibatches)
        steps = min(settings.minibatches, count // each)
        orders = [
            jax.random.permutation(one, count)[: steps * each].reshape(steps, each)
            for one in jax.random.split(key, settings.epochs)
        ]
        return jnp.concatenate(orders)

    def _step(
        self, data: Data, rate: jax.Array, carry: tuple[Any, Any], places: jax.Array
    ) -> tuple[tuple[Any, Any], Measures]:
        """One step along the gradient of some sequences."""
        weights, optimiser = carry
        some = jax.tree.map(lambda leaf: leaf[:, places], data)
        (_, measures), gradient = jax.value_and_grad(self.loss, has_aux=True)(weights, some)
        change, optimiser = stepped(self._optimiser(), gradient, optimiser)
        weights = jax.tree.map(lambda old, change: old + rate * change, weights, change)
        return (weights, optimiser), measures

    def loss(self, weights: Any, data: Data) -> tuple[jax.Array, Measures]:
        """What is made small: minus PPO's objective and the entropy, plus the value's squared error.

        Measures: objective, value_loss, entropy, kl (estimated as by Schulman, joschu.net/blog/kl-approx.html), and
        clipped, the share of samples whose ratio is further from 1 than counts.
        """
        settings, weight = self.settings, data.able.astype(jnp.float32)
        hidden = layers.unrolled(weights["network"], data.memory[0], data.figures)
        likely = objective.log_probabilities(layers.head(weights["network"]["out"], hidden), data.mask)
        taken = jnp.take_along_axis(likely, data.action[..., None], axis=-1)[..., 0]
        apart = taken - data.log_probability
        ratio = jnp.exp(apart)
        gain = objective.mean(objective.clipped(ratio, data.advantage, settings.clip), weight)
        value = layers.head(weights["value"], hidden)[..., 0]
        value_loss = np.float32(0.5) * objective.mean((value - data.target) ** 2, weight)
        entropy = objective.mean(objective.entropy(likely, data.mask), weight)
        loss = np.float32(settings.value) * value_loss - gain - np.float32(settings.entropy) * entropy
        far = jnp.abs(ratio - np.float32(1)) > np.float32(settings.clip)
        return loss, {
            "loss": loss,
            "objective": gain,
            "value_loss": value_loss,
            "entropy": entropy,
            "kl": objective.mean(ratio - np.float32(1) - apart, weight),
            "clipped": objective.mean(far.astype(jnp.float32), weight),
        }


def _norm(tree: Any) -> jax.Array:
    return jnp.sqrt(sum((jnp.sum(leaf**2) for leaf in jax.tree.leaves(tree)), jnp.zeros((), jnp.float32)))


def _sequences(of_steps: jax.Array, length: int) -> jax.Array:
    """[T, n, B, ...] as [L, T / L x n x B, ...]: step after step within a sequence."""
    steps, *batch = of_steps.shape[:3]
    parts = of_steps.reshape(steps // length, length, *batch, *of_steps.shape[3:])
    count = parts.shape[0] * math.prod(batch)
    return jnp.moveaxis(parts, 1, 0).reshape(length, count, *of_steps.shape[3:])
