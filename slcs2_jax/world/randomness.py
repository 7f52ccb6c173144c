"""Random numbers of an episode: a counter-based hash, so that a draw depends on its name and never on the batch.

A draw is named by (episode key, time-step, purpose, index). The same name gives the same 32 bits on every backend, in
any batch, in any order; nothing has to be carried from step to step. The mixing function is Wellons' ``lowbias32`` with
the second half of the 64-bit stream state added between its two rounds; the tests look at the statistics.
"""

from __future__ import annotations

import enum

import jax
import jax.numpy as jnp
import numpy as np

GOLDEN = np.uint32(0x9E3779B9)


class Purpose(enum.IntEnum):
    """What a draw is for; draws of different purposes are independent."""

    SHADOWING = 0
    RULE = 1
    COLLECT = 2
    FADING = 3  # further words of a link, where one does not do
    JAMMER_LINK = 4  # links of the second jammer and further ones
    EMISSION = 5
    FAILURE = 6
    RECOVERY = 7
    FAILURE_LOT = 8  # who fails at a given time
    POLICY = 16


def _first_round(x: jax.Array) -> jax.Array:
    x = x ^ (x >> np.uint32(16))
    x = x * np.uint32(0x7FEB352D)
    return x ^ (x >> np.uint32(15))


def _second_round(x: jax.Array) -> jax.Array:
    x = x * np.uint32(0x846CA68B)
    return x ^ (x >> np.uint32(16))


def mix(x: jax.Array) -> jax.Array:
    """Scramble 32-bit words (``lowbias32``): a bijection on uint32 of any shape."""
    return _second_round(_first_round(x))


def stream(key: jax.Array, t: jax.Array, purpose: Purpose) -> tuple[jax.Array, jax.Array]:
    """The stream of a time-step's draws for one purpose: its 64-bit state, uint32 [...] twice.

    Args:
        key: uint32 [2, ...], the episode's key.
        t: int32 [...], the time-step.
        purpose: what the draws are for.
    """
    step = mix(key[0] + t.astype(jnp.uint32)) ^ key[1]
    low = mix(step + np.uint32(int(purpose) * int(GOLDEN) & 0xFFFFFFFF))
    return low, mix(low + key[0])


def bits(stream: tuple[jax.Array, jax.Array], index: jax.Array | np.ndarray) -> jax.Array:
    """Uniform 32-bit words.

    Args:
        stream: uint32 [...] twice, from ``stream``.
        index: uint32 [I..., 1...], which draw; broadcast against the stream.

    Returns:
        uint32 [I..., ...].
    """
    low, high = stream
    return _second_round(_first_round(low ^ (index * GOLDEN)) + high)


def uniform(words: jax.Array) -> jax.Array:
    """Uniform numbers from uniform words: float32, from 2^-24 to 1 - 2^-24, so that 0 and 1 never come."""
    return (words >> np.uint32(9)).astype(jnp.int32).astype(jnp.float32) * np.float32(2**-23) + np.float32(2**-24)


# Giles (2010), "Approximating the erfinv function", single precision; constant term last.
_CENTRE = (2.81022636e-08, 3.43273939e-07, -3.5233877e-06, -4.39150654e-06, 0.00021858087, -0.00125372503,
           -0.00417768164, 0.246640727, 1.50140941)  # fmt: skip
_TAIL = (-0.000200214257, 0.000100950558, 0.00134934322, -0.00367342844, 0.00573950773, -0.0076224613,
         0.00943887047, 1.00167406, 2.83297682)  # fmt: skip


def _polynomial(coefficients: tuple[float, ...], w: jax.Array) -> jax.Array:
    value = jnp.full_like(w, coefficients[0])
    for coefficient in coefficients[1:]:
        value = value * w + np.float32(coefficient)
    return value


def normal(words: jax.Array) -> jax.Array:
    """Standard normal deviates from uniform words, by the inverse distribution function.

    Args:
        words: uint32 of any shape.

    Returns:
        float32 of the same shape, between -5.5 and 5.5.
    """
    half = np.float32(2**-24)
    x = (words >> np.uint32(8)).astype(jnp.int32).astype(jnp.float32) * (2 * half) + (half - np.float32(1.0))
    w = -jnp.log((np.float32(1.0) - x) * (np.float32(1.0) + x))
    centre = _polynomial(_CENTRE, w - np.float32(2.5))
    tail = _polynomial(_TAIL, jnp.sqrt(w) - np.float32(3.0))
    return np.float32(np.sqrt(2.0)) * x * jnp.where(w < np.float32(5.0), centre, tail)
