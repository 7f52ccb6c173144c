"""One vector of what an agent sees, for learners that take nothing else."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from slcs2_jax.env import Env, Seen


def names(env: Env, clauses: bool) -> tuple[str, ...]:
    """What each entry of `vector` is: names of features and, if they are wanted, clauses in words."""
    return (*(feature.name for feature in env.features), *(env.clauses if clauses else ()))


def vector(seen: Seen, clauses: bool) -> jax.Array:
    """The features and, if they are wanted, the truth of the clauses as 0 or 1: float32 [n, F] or [n, F + K]."""
    if not clauses:
        return seen.features
    return jnp.concatenate([seen.features, seen.clauses.astype(jnp.float32)], axis=-1)
