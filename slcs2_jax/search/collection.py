"""The collection of solutions under novelty domination (paper, Solution-Collection update; docs/model.md)."""

from __future__ import annotations

from typing import Any

import numpy as np

from slcs2_jax.search.held import Held
from slcs2_jax.search.member import Member
from slcs2_jax.search.novelty import NoveltyIndex
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem


def domination(
    fitness_x: float | np.ndarray, fitness_y: float | np.ndarray, distance: np.ndarray, omega: float
) -> np.ndarray:
    """e(x, y) = f(x) - f(y) - omega Delta b(x, y); x dominates y iff it is > 0. Broadcasts."""
    return np.subtract(fitness_x, fitness_y) - omega * np.asarray(distance)


class Collection(Held):
    """Members that do not dominate each other at the time they meet: fit, or far from those that are fitter."""

    def __init__(self, problem: Problem) -> None:
        """`search.omega0` weighs novelty against fitness: omega = omega0 / members."""
        super().__init__()
        self._omega0 = problem.settings.omega0
        self._shape = problem.shape
        self._index = NoveltyIndex(*self._shape)

    @property
    def omega(self) -> float:
        """Weight of novelty for the next newcomer: omega0 / |Y|, |Y| without the newcomer and at least 1."""
        return self._omega0 / max(1, len(self._members))

    def consider(self, newcomer: Member) -> Verdict:
        """x enters iff no y has e(y, x) > 0; only then every y with e(x, y) > 0 leaves."""
        ids = newcomer.solution.ids
        distance = self._index.distances(ids)
        fitness = np.array([member.fitness for member in self._members])
        omega, mean = self.omega, float(distance.mean()) if distance.size else float("nan")
        if (domination(fitness, newcomer.fitness, distance, omega) > 0).any():
            return Verdict(accepted=False, novelty=mean, removed=(), size=len(self._members))
        leaving = np.flatnonzero(domination(newcomer.fitness, fitness, distance, omega) > 0)
        removed = tuple(self._members[position].generation for position in leaving)
        if leaving.size:
            gone = set(leaving.tolist())
            self._members = [member for position, member in enumerate(self._members) if position not in gone]
            self._index.remove(leaving)
        self._append(newcomer, ids)
        return Verdict(accepted=True, novelty=mean, removed=removed, size=len(self._members))

    def _append(self, member: Member, ids: np.ndarray) -> None:
        self._members.append(member)
        self._index.add(ids)

    def restore(self, members: list[Member], state: dict[str, Any]) -> None:
        """Hold exactly these members, in this order."""
        self._members, self._index = [], NoveltyIndex(*self._shape)
        for member in members:
            self._append(member, member.solution.ids)
