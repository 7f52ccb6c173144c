"""What the properties share: how many inputs, how files are spoilt, what a complaint looks like."""

from __future__ import annotations

import os
import random

from hypothesis import settings
from hypothesis import strategies as st

from slcs2_jax.config import InputError

INPUTS = int(os.environ.get("SLCS2_INPUTS", "200"))
many = settings(max_examples=INPUTS)


def one_line(error: InputError) -> None:
    assert "\n" not in str(error)
    assert len(str(error)) < 800


def spoilt(data: bytes, number: int) -> bytes:
    """Anything at all, or the data with something cut, put in, doubled or changed: by its number, always the same."""
    rng = random.Random(number)
    kind = rng.choice(["any", "cut", "insert", "double", "change", "change many"])
    if kind == "any":
        return rng.randbytes(rng.randint(0, 400))
    start = rng.randint(0, len(data))
    end = min(len(data), start + rng.randint(0, 60))
    if kind == "cut":
        return data[:start] + data[end:]
    if kind == "insert":
        return data[:start] + rng.randbytes(rng.randint(1, 8)) + data[start:]
    if kind == "double":
        return data[:end] + data[start:]
    changed = bytearray(data)
    for _ in range(1 if kind == "change" else rng.randint(1, 20)):
        changed[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(changed)


def documents(names: list[str], words: list[str]) -> st.SearchStrategy:
    """Values as YAML and JSON have them: nested, with these names and words among others."""
    leaves = st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.integers(-2, 12),
        st.floats(),
        st.sampled_from(words),
        st.text(max_size=8),
    )
    keys = st.one_of(st.sampled_from(names), st.text(max_size=5), st.integers(0, 3), st.booleans())
    return st.recursive(
        leaves, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=4), max_leaves=12
    )
