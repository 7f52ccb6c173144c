"""What PPO climbs."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np


def clipped(ratio: jax.Array, advantage: jax.Array, clip: float) -> jax.Array:
    """PPO's objective of every sample (Schulman et al. 2017, arXiv 1707.06347, equation 7): float32 [...].

    min(r A, clip(r, 1 - epsilon, 1 + epsilon) A), with r how much likelier the action is than when it was taken.
    """
    low, high = np.float32(1 - clip), np.float32(1 + clip)
    return jnp.minimum(ratio * advantage, jnp.clip(ratio, low, high) * advantage)


def log_probabilities(logits: jax.Array, mask: jax.Array) -> jax.Array:
    """Of actions that could have an effect; 0 for the others, which are never taken: float32 [..., A]."""
    kept = jnp.where(mask, logits, np.float32(-1e9))
    return jnp.where(mask, jax.nn.log_softmax(kept), np.float32(0))


def entropy(log_probability: jax.Array, mask: jax.Array) -> jax.Array:
    """Of the choice among the actions that are not masked, nats: float32 [...]."""
    return -jnp.sum(jnp.where(mask, jnp.exp(log_probability) * log_probability, np.float32(0)), axis=-1)


def mean(value: jax.Array, weight: jax.Array) -> jax.Array:
    """Of the samples with weight 1: float32 []."""
    return jnp.sum(value * weight) / jnp.maximum(jnp.sum(weight), np.float32(1))
