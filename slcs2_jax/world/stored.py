"""Keeping intermediate values in memory instead of computing them again in every reader."""

from __future__ import annotations

from typing import TypeVar

import jax
import jax.numpy as jnp

Tree = TypeVar("Tree")


def stored(tree: Tree, witness: jax.Array) -> Tree:
    """The arrays of ``tree`` as they are, computed once and stored.

    XLA's CPU compiler puts a copy of everything elementwise into every loop that reads it, however much that is, and a
    reduction with such a copy inside is not vectorised. It heeds no optimisation barrier, but does not look behind a
    branch. GPUs need no such help, and there a branch is slow.

    Args:
        tree: any arrays.
        witness: a scalar that is not negative, which the compiler cannot know: a parameter.
    """
    return jax.lax.platform_dependent(tree, witness, cpu=_behind_branch, default=lambda tree, _: tree)


def _behind_branch(tree: Tree, witness: jax.Array) -> Tree:
    return jax.lax.cond(witness >= 0, lambda tree: tree, lambda tree: jax.tree.map(jnp.zeros_like, tree), tree)


def kept(tree: Tree) -> Tree:
    """The arrays of ``tree`` as they are, on GPUs computed once and stored; elsewhere this is nothing.

    XLA's GPU compiler guesses what is better computed again by every reader. Where it guesses wrong, say so with this.
    """
    return jax.lax.platform_dependent(tree, cpu=lambda tree: tree, default=jax.lax.optimization_barrier)
