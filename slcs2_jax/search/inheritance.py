"""Inherited quality (Lamarckian): what offspring start with. [n, R] = agents, rules.

A kept rule has the quality that its parent's had learnt, a copied one its donor's, and a fresh one the greatest of its
rule-set: it is tried before those that disappoint (optimism; Sutton and Barto, Reinforcement Learning, section 2.6).
"""

from __future__ import annotations

import numpy as np

from slcs2_jax.grammar import RuleSets
from slcs2_jax.search.evaluation import Evaluation


def learnt_quality(rules: RuleSets, evaluation: Evaluation, initial: float) -> np.ndarray:
    """float32[n, R]: q at the end for rules that were used; for others what they began with, `initial` by default."""
    began = np.full(rules.action.shape, initial, np.float32) if rules.quality is None else rules.quality
    return np.where(evaluation.used, evaluation.figures.quality, began).astype(np.float32)


def with_fresh(quality: np.ndarray, fresh: np.ndarray, parent: np.ndarray) -> np.ndarray:
    """The quality float32[n, R] of a child in which the rules bool[n, R] `fresh` are new.

    They get the greatest of the others of their rule-set; where all are new, the greatest of the parent's rule-set.
    """
    rest = np.where(fresh, -np.inf, quality).max(axis=1, keepdims=True)
    greatest = np.where(np.isfinite(rest), rest, parent.max(axis=1, keepdims=True))
    return np.where(fresh, greatest, quality).astype(np.float32)
