"""What an agent may be given and may do, in JaxMARL's form, for where JaxMARL is not installed."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp


class Discrete:
    """Whole numbers below n."""

    def __init__(self, num_categories: int, dtype: Any = jnp.int32) -> None:
        self.n, self.shape, self.dtype = num_categories, (), dtype

    def sample(self, rng: jax.Array) -> jax.Array:
        """One of them, all alike."""
        return jax.random.randint(rng, self.shape, 0, self.n).astype(self.dtype)

    def contains(self, x: jax.Array) -> jax.Array:
        """Whether x is one of them."""
        return (x >= 0) & (x < self.n)


class Box:
    """Arrays of one shape between bounds."""

    def __init__(self, low: Any, high: Any, shape: tuple[int, ...], dtype: Any = jnp.float32) -> None:
        self.low, self.high, self.shape, self.dtype = low, high, shape, dtype

    def sample(self, rng: jax.Array) -> jax.Array:
        """Uniform between the bounds, which must be finite."""
        return jax.random.uniform(rng, self.shape, self.dtype, self.low, self.high)

    def contains(self, x: jax.Array) -> jax.Array:
        """Whether every entry of x is within the bounds."""
        return jnp.all((x >= self.low) & (x <= self.high))
