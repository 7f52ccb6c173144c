"""A control without a search: some random solutions, deployed again by turns until all episodes are spent.

With knowledge they are what other searches begin with (its rules as reflexes before random ones). What a search adds to
them is what it comes to beside the best of these, chosen by as many episodes.
"""

from __future__ import annotations

from typing import Any

from slcs2_jax.search.again import again, joined
from slcs2_jax.search.base import BaseSearch
from slcs2_jax.search.member import Member
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.solution import Solution
from slcs2_jax.search.trial import Trial


class Starters(BaseSearch):
    """`search.starts` random solutions; the fittest by all of its deployments wins, the earliest on ties."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self._members: list[Member] = []

    @property
    def members(self) -> list[Member]:
        """All of them, the earliest first."""
        return list(self._members)

    def ask(self, count: int = 1) -> list[Solution]:
        """See `Search.ask`: no solution twice at once."""
        starts = self.settings.starts
        return super().ask(min(max(1, count), starts - self.generation % starts))

    def propose(self, generation: int) -> Solution:
        """A random one, then those there are by turns."""
        starts = self.settings.starts
        if generation < starts:
            return self.problem.random_solution(self.supply, generation)
        return again(self._members[generation % starts].solution, generation)

    def trial(self, solution: Solution) -> Trial:
        """`search.final_deployments` each time, or one in each of many worlds."""
        worlds = self.problem.worlds
        return self._fixed(solution, self.settings.final_deployments if worlds == 1 else worlds)

    def consider(self, newcomer: Member) -> Verdict:
        """The deployments join those of the solution that was deployed again."""
        if newcomer.generation < self.settings.starts:
            self._members.append(newcomer)
        else:
            self._members = joined(self._members, newcomer)
        return Verdict(size=len(self._members))

    def _take(self, newcomer: Member) -> Verdict:
        verdict = super()._take(newcomer)
        self._best = max(self._members, key=lambda member: (member.fitness, -member.generation))
        return verdict

    def recall(self, members: list[Member], kept: dict[str, Any]) -> None:
        """Hold exactly these members."""
        self._members = list(members)
