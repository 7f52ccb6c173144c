"""Random search: every solution is new and random. What evolution must be compared with, for equal episodes."""

from __future__ import annotations

from slcs2_jax.search.base import BaseSearch
from slcs2_jax.search.member import Member
from slcs2_jax.search.novelty import novelty
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.solution import Solution


class RandomSearch(BaseSearch):
    """Solutions without parents, evaluated by the same rule as any; the fittest is kept.

    `search.episodes` gives it the episodes that another search spent; the last solution may go beyond them by the
    re-deployments that it has begun.
    """

    def propose(self, generation: int) -> Solution:
        """Random rules."""
        return self.problem.random_solution(self.supply, generation)

    def consider(self, newcomer: Member) -> Verdict:
        """Accepted is what is fitter than all before; novelty is the distance to the best so far."""
        former = self._best
        if former is None:
            return Verdict(size=1)
        distance = novelty(newcomer.solution.ids, former.solution.ids)
        if newcomer.fitness > former.fitness:
            return Verdict(novelty=distance, removed=(former.generation,), size=1)
        return Verdict(accepted=False, novelty=distance, size=1)
