"""The match set Gamma': the rules whose every clause holds (model section 6.1)."""

from __future__ import annotations

import functools
import operator

import jax
import numpy as np


def match_set(mask: jax.Array, truth: jax.Array) -> jax.Array:
    """Which rules hold.

    Args:
        mask: uint32 [W, R, n, ...], the clauses of each rule.
        truth: uint32 [>= W, n, ...], the clauses that are true.

    Returns:
        bool [R, n, ...].
    """
    unmet = [mask[w] & ~truth[w] for w in range(mask.shape[0])]
    return functools.reduce(operator.or_, unmet) == np.uint32(0)
