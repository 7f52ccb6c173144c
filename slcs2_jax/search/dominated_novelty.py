"""Dominated novelty search: solutions compete by how far they are from those that are fitter.

Bahlous-Boldi, Faldor, Grillotti, Janmohamed, Coiffard, Spector and Cully, Dominated Novelty Search: rethinking local
competition in quality-diversity, GECCO 2025 (arXiv 2502.00593).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.search.held import Held
from slcs2_jax.search.member import Member
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.sharing import sharing

NEIGHBOURS = 3  # fitter solutions that the mean distance is taken to, as in the paper


def dominated_novelty(fitness: NDArray[np.float64], descriptors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean distance of each solution to the nearest `NEIGHBOURS` of those that are fitter; infinite without any.

    Args:
        fitness: float64 [M]; of equals the earlier one counts as fitter, so that copies do not keep each other.
        descriptors: float64 [M, D].

    Returns:
        float64 [M].
    """
    order = np.arange(len(fitness))
    fitter = (fitness > fitness[:, None]) | ((fitness == fitness[:, None]) & (order < order[:, None]))
    distance = np.linalg.norm(descriptors[:, None] - descriptors, axis=-1)
    nearest = np.sort(np.where(fitter, distance, np.inf), axis=1)[:, :NEIGHBOURS]
    known = np.isfinite(nearest)
    count = known.sum(axis=1)
    total = np.where(known, nearest, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.inf)


class DominatedNovelty(Held):
    """The `search.population` solutions of the greatest dominated novelty; each newcomer puts the least out."""

    def __init__(self, problem: Problem) -> None:
        super().__init__()
        self._most = problem.settings.population

    def consider(self, newcomer: Member) -> Verdict:
        """See `Acceptance`; the verdict's novelty is the newcomer's dominated novelty, if any other is fitter."""
        self._members.append(newcomer)
        value = dominated_novelty(
            np.array([member.fitness for member in self._members]),
            np.array([sharing(member.evaluation) for member in self._members]),
        )
        novelty = float(value[-1]) if np.isfinite(value[-1]) else float("nan")
        if len(self._members) <= self._most:
            return Verdict(novelty=novelty, size=len(self._members))
        leaving = self._members.pop(int(np.argmin(value)))  # of equals the oldest
        accepted = leaving is not newcomer
        removed = (leaving.generation,) if accepted else ()
        return Verdict(accepted=accepted, novelty=novelty, removed=removed, size=len(self._members))
