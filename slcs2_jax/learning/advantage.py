"""How much better an action was than expected, and on which scale values are learnt."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np


def advantages(
    reward: jax.Array,
    value: jax.Array,
    terminated: jax.Array,
    over: jax.Array,
    *,
    discount: float,
    decay: float,
) -> jax.Array:
    """Generalised advantage estimates (Schulman et al. 2016, arXiv 1506.02438, equation 16).

    delta_t = r_t + gamma V(s_t+1) - V(s_t), and A_t = delta_t + gamma lambda A_t+1. Where the task is done, nothing is
    to come: V(s_t+1) is 0. Where time is up, or the data end, what would have come is worth V(s_t+1) (Pardo et al.
    2018, arXiv 1712.00378). In neither case does anything of the next episode count.

    Args:
        reward: float32 [T, ...], of a step.
        value: float32 [T + 1, ...], V before each step and after the last; in reward's unit.
        terminated: bool [T, ...], the task was done with this step.
        over: bool [T, ...], the episode ended with this step, or before.
        discount: gamma.
        decay: lambda.

    Returns:
        float32 [T, ...].
    """
    bootstrap = jnp.where(terminated, np.float32(0), value[1:])
    delta = reward + np.float32(discount) * bootstrap - value[:-1]

    def back(later: jax.Array, step: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        delta, over = step
        one = delta + jnp.where(over, np.float32(0), np.float32(discount * decay) * later)
        return one, one

    return jax.lax.scan(back, jnp.zeros_like(delta[0]), (delta, over), reverse=True)[1]


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Scale:
    """Running mean and variance of returns: the network's value is in their units (Yu et al. 2022, arXiv 2103.01955).

    weight: float32, how much was seen of 1; mean, square: float32, times it.
    """

    weight: jax.Array
    mean: jax.Array
    square: jax.Array

    @classmethod
    def new(cls) -> Scale:
        """Nothing seen: mean 0, deviation 1."""
        return cls(*(jnp.zeros((), jnp.float32) for _ in range(3)))

    def seen(self, returns: jax.Array, weight: jax.Array, decay: float) -> Scale:
        """With these returns, float32 [...], of which those of weight 1 count and those of weight 0 do not."""
        total = jnp.maximum(jnp.sum(weight), np.float32(1))
        old, new = np.float32(decay), np.float32(1 - decay)
        mean, square = jnp.sum(returns * weight) / total, jnp.sum(returns**2 * weight) / total
        return Scale(old * self.weight + new, old * self.mean + new * mean, old * self.square + new * square)

    @property
    def moments(self) -> tuple[jax.Array, jax.Array]:
        """Mean and standard deviation, float32."""
        weight = jnp.where(self.weight > 0, self.weight, np.float32(1))
        mean, square = self.mean / weight, self.square / weight
        deviation = jnp.sqrt(jnp.maximum(square - mean**2, np.float32(1e-4)))
        return mean, jnp.where(self.weight > 0, deviation, np.float32(1))

    def real(self, value: jax.Array) -> jax.Array:
        """The network's value in the reward's unit."""
        mean, deviation = self.moments
        return value * deviation + mean

    def scaled(self, returns: jax.Array) -> jax.Array:
        """Returns in the unit of the network's value."""
        mean, deviation = self.moments
        return (returns - mean) / deviation
