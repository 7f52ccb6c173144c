"""Random numbers of an episode: a counter-based hash, so that every draw is a function of (key, step, purpose, index).

All arithmetic is modulo 2^32. The masks make it so for Python's integers and for Numba's 64-bit ones alike
(int() keeps NumPy's, which would complain, out).
"""

from __future__ import annotations

import math

SHADOWING, PRIORITY, COLLECT = 0, 1, 2  # purposes
WORD = 0xFFFFFFFF
GOLDEN = 0x9E3779B9


def mix(x):
    """Bijection of 32-bit words in which every input bit moves every output bit."""
    x ^= x >> 16
    x = (x * 0x7FEB352D) & WORD
    x ^= x >> 15
    x = (x * 0x846CA68B) & WORD
    return x ^ (x >> 16)


def stream(key0, key1, t, purpose):
    """The two words that name the draws of one purpose at step t of the episode (key0, key1)."""
    key0, key1 = int(key0), int(key1)
    s1 = mix((mix((key0 + t) & WORD) ^ key1) + purpose * GOLDEN & WORD)
    return s1, mix((s1 + key0) & WORD)


def draw(s1, s2, index):
    """32 uniform bits: number `index` of the stream."""
    x = s1 ^ ((int(index) * GOLDEN) & WORD)
    x ^= x >> 16
    x = (x * 0x7FEB352D) & WORD
    x ^= x >> 15
    x = ((x + s2) * 0x846CA68B) & WORD
    return x ^ (x >> 16)


def normal(bits):
    """Standard normal from 32 uniform bits, of which 24 count: sqrt(2) erfinv(2u - 1), u = ((bits >> 8) + 1/2) 2^-24.

    erfinv by Giles' single precision polynomials ("Approximating the erfinv function", 2010).
    """
    x = (2 * (bits >> 8) + 1 - 0x1000000) / 16777216.0
    w = -math.log((1.0 - x) * (1.0 + x))
    if w < 5.0:
        w -= 2.5
        p = 2.81022636e-08
        p = 3.43273939e-07 + p * w
        p = -3.5233877e-06 + p * w
        p = -4.39150654e-06 + p * w
        p = 0.00021858087 + p * w
        p = -0.00125372503 + p * w
        p = -0.00417768164 + p * w
        p = 0.246640727 + p * w
        p = 1.50140941 + p * w
    else:
        w = math.sqrt(w) - 3.0
        p = -0.000200214257
        p = 0.000100950558 + p * w
        p = 0.00134934322 + p * w
        p = -0.00367342844 + p * w
        p = 0.00573950773 + p * w
        p = -0.0076224613 + p * w
        p = 0.00943887047 + p * w
        p = 1.00167406 + p * w
        p = 2.83297682 + p * w
    return 1.4142135623730951 * p * x
