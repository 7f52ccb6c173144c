"""Sets of rules as bits, so that little is moved where a set is kept from step to step.

The R rules are cut into W = ceil(R / 32) stretches of ceil(R / W), one for each word: 100 rules take four words of 25
bits. So few bits are to spare, mostly none, and XLA unpacks a set within whatever reads it.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

WORD_BITS = 32


def words(rules: int) -> int:
    """How many words a set of so many rules takes: W."""
    return -(-rules // WORD_BITS)


def pack(members: jax.Array) -> jax.Array:
    """A set, bool [R, ...], as uint32 [W, ...]."""
    rules, *rest = members.shape
    count = words(rules)
    length = -(-rules // count)
    whole = jnp.pad(members, [(0, count * length - rules), *[(0, 0)] * len(rest)])
    bits = whole.reshape(count, length, *rest).astype(jnp.uint32) << _places(length, rest)
    return jnp.stack([jnp.sum(word, axis=0, dtype=jnp.uint32) for word in bits])


def unpack(packed: jax.Array, rules: int) -> jax.Array:
    """The set of so many rules that `pack` made uint32 [W, ...] of: bool [R, ...]."""
    count, *rest = packed.shape
    bits = packed[:, None] >> _places(-(-rules // count), rest) & np.uint32(1)
    return bits.reshape(-1, *rest)[:rules] == np.uint32(1)


def _places(length: int, rest: list[int]) -> np.ndarray:
    """0, 1, ..., to be spread over words [length, ...]."""
    return np.arange(length, dtype=np.uint32).reshape(length, *(1,) * len(rest))
