"""A population of the fittest, and tournaments among its members."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slcs2_jax.search.held import Held
from slcs2_jax.search.member import Member
from slcs2_jax.search.novelty import novelty
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem


class Best(Held):
    """The `search.population` fittest solutions; of equals the earlier ones stay."""

    def __init__(self, problem: Problem) -> None:
        super().__init__()
        self._most = problem.settings.population

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


class Tournament:
    """The fittest of `search.tournament` members drawn with replacement; the newest on ties."""

    def __init__(self, problem: Problem) -> None:
        self._size = problem.settings.tournament

    def __call__(self, members: Sequence[Member], rng: np.random.Generator) -> Member:
        """See `ParentChoice`."""
        drawn = [members[place] for place in rng.integers(len(members), size=self._size).tolist()]
        return max(drawn, key=lambda member: (member.fitness, member.generation))
