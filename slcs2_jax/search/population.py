"""A population of the fittest, and tournaments among its members."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from slcs2_jax.search.member import Member
from slcs2_jax.search.novelty import novelty
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem


class Best:
    """The `search.population` fittest solutions; of equals the earlier ones stay."""

    def __init__(self, problem: Problem) -> None:
        self._most = problem.settings.population
        self._members: list[Member] = []

    def members(self) -> list[Member]:
        """The members, oldest first."""
        return list(self._members)

    def consider(self, newcomer: Member) -> Verdict:
        """The newcomer enters while there is room, or if it is fitter than the least fit, which leaves."""
        ids = newcomer.solution.ids
        distances = [novelty(ids, member.solution.ids) for member in self._members]
        mean = float(np.mean(distances)) if distances else float("nan")
        removed: tuple[int, ...] = ()
        if len(self._members) >= self._most:
            last = min(self._members, key=lambda member: (member.fitness, -member.generation))
            if newcomer.fitness <= last.fitness:
                return Verdict(accepted=False, novelty=mean, size=len(self._members))
            self._members.remove(last)
            removed = (last.generation,)
        self._members.append(newcomer)
        return Verdict(accepted=True, novelty=mean, removed=removed, size=len(self._members))

    def state(self) -> dict[str, Any]:
        """Nothing besides the members is remembered."""
        return {}

    def restore(self, members: list[Member], state: dict[str, Any]) -> None:
        """Hold exactly these members, in this order."""
        self._members = list(members)


class Tournament:
    """The fittest of `search.tournament` members drawn with replacement; the newest on ties."""

    def __init__(self, problem: Problem) -> None:
        self._size = problem.settings.tournament

    def __call__(self, members: Sequence[Member], rng: np.random.Generator) -> Member:
        """See `ParentChoice`."""
        drawn = [members[place] for place in rng.integers(len(members), size=self._size).tolist()]
        return max(drawn, key=lambda member: (member.fitness, member.generation))
