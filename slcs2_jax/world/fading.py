"""How received power varies around its mean: drawn for every link and step, the same in both directions (model 3, 11).

A fading model is a pytree of parameters with two functions; a user's own is a class of this form registered as
`register("fading", name)`. But for the log-normal one, whose mean is 0 in dB as in the paper, gains have mean 1.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.world.propagation import DB_TO_LOG2
from slcs2_jax.world.randomness import normal, uniform

Words = Callable[[int], jax.Array]  # the k-th uniform word of every link: uint32 [...]

TRIES = 4  # of Marsaglia and Tsang's method


class Fading(Protocol):
    """What a fading model offers."""

    @classmethod
    def of(cls, radio: Any) -> Fading:
        """The parameters from the settings `radio`, or from anything with its attributes, numbers or traced arrays."""
        ...

    def gain(self, words: Words) -> jax.Array | None:
        """log2 of each link's gain in power: float32 [...], finite; None for no fading at all."""
        ...


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class NoFading:
    """Every link at its mean, always."""

    @classmethod
    def of(cls, radio: Any) -> NoFading:
        """Nothing to take."""
        return cls()

    def gain(self, words: Words) -> jax.Array | None:
        """None."""
        return None


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class LogNormal:
    """Log-normal shadowing, X ~ N(0, sigma^2) in dB, drawn anew in every step as the paper has it (model 3).

    Its mean in dB is 0; in linear power it is exp((sigma ln 10 / 10)^2 / 2), 1.53 at 4 dB.
    """

    sigma: jax.Array  # log2 units, standard deviation

    @classmethod
    def of(cls, radio: Any) -> LogNormal:
        """From radio.shadowing_db."""
        return cls(jnp.float32(radio.shadowing_db * DB_TO_LOG2))

    def gain(self, words: Words) -> jax.Array:
        """A normal deviate of one word."""
        return self.sigma * normal(words(0))


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Rayleigh:
    """Many scattered paths and no direct one: power times Exp(1).

    Simon and Alouini, Digital Communication over Fading Channels (2nd ed. 2005), section 2.2.1.1.
    """

    @classmethod
    def of(cls, radio: Any) -> Rayleigh:
        """Nothing to take."""
        return cls()

    def gain(self, words: Words) -> jax.Array:
        """By the inverse distribution function, of one word."""
        return jnp.log2(-jnp.log(uniform(words(0))))


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Rician:
    """A direct path with K times the power of the scattered ones: noncentral chi2, 2 degrees of freedom, mean 1.

    |h|^2 = ((X + sqrt(2K))^2 + Y^2) / (2 (K + 1)) with X, Y ~ N(0, 1); K = 0 is Rayleigh fading. Simon and Alouini
    (2005), section 2.2.1.3.
    """

    k: jax.Array  # a ratio

    @classmethod
    def of(cls, radio: Any) -> Rician:
        """From radio.rician_k."""
        return cls(jnp.float32(radio.rician_k))

    def gain(self, words: Words) -> jax.Array:
        """Of two words; two deviates that are both nearly 0 count as 10^-12."""
        direct = normal(words(0)) + jnp.sqrt(2 * self.k)
        scattered = normal(words(1))
        power = (direct * direct + scattered * scattered) / (2 * (self.k + np.float32(1)))
        return jnp.log2(jnp.maximum(power, np.float32(1e-12)))


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Nakagami:
    """Gamma(m, 1/m), mean 1, m >= 0.5; m = 1 is Rayleigh fading. Simon and Alouini (2005), section 2.2.1.4.

    Drawn by Marsaglia and Tsang, A simple method for generating gamma variables, ACM TOMS 26 (2000): of `TRIES` pairs
    of words the first that the method accepts. With chance (1 - 0.951)^TRIES, under 6 in a million draws at m = 1 and
    fewer at any other m, none is accepted, and the mean of the method's deviate, d + 1/3, is taken. For m < 1 a deviate
    of m + 1 times U^(1/m), as there.
    """

    m: jax.Array

    @classmethod
    def of(cls, radio: Any) -> Nakagami:
        """From radio.nakagami_m."""
        return cls(jnp.float32(radio.nakagami_m))

    def gain(self, words: Words) -> jax.Array:
        """Of 2 TRIES + 1 words."""
        one = np.float32(1)
        boosted = self.m < 1
        shape = jnp.where(boosted, self.m + one, self.m)
        d = shape - np.float32(1 / 3)
        c = one / jnp.sqrt(np.float32(9) * d)
        drawn = jnp.broadcast_to(shape, words(0).shape)
        for trial in reversed(range(TRIES)):
            x, u = normal(words(2 * trial)), uniform(words(2 * trial + 1))
            root = one + c * x
            v = jnp.where(root > 0, root, one) ** 3
            accepted = (root > 0) & (jnp.log(u) < np.float32(0.5) * x * x + d * (one - v + jnp.log(v)))
            drawn = jnp.where(accepted, d * v, drawn)
        boost = jnp.where(boosted, jnp.log2(uniform(words(2 * TRIES))) / self.m, np.float32(0))
        return jnp.log2(drawn / self.m) + boost
