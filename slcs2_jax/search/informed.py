"""This project's own search: the paper's with finals, made to go with the parts in conf/search/informed.yaml.

From final to final it is `Slcs2`. Deployments of a final count for the solution that was deployed again: fitness and
what was learnt are means over all of its deployments, and parents are chosen by them.
"""

from __future__ import annotations

from typing import Any

from slcs2_jax.config import InputError
from slcs2_jax.search.again import again, joined
from slcs2_jax.search.final import Schedule
from slcs2_jax.search.member import Member
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.slcs2 import Slcs2
from slcs2_jax.search.solution import Solution
from slcs2_jax.search.trial import Trial


class Informed(Slcs2):
    """Evolution with knowledge, and deployments where they decide.

    The best is the solution, of those held and the former best, whose mean less a standard error is greatest, by the
    noise measured so far: what a few lucky deployments say counts less than what many say.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self._schedule = Schedule(self.settings.finalists, self.settings.final_every)
        self._last: int | None = None  # first generation of the final that ends a search with `search.episodes`
        self._round: list[int] = []  # generations of the solutions in the final's present round, the fittest first

    @property
    def finished(self) -> bool:
        """All generations are made, or with `search.episodes` the one final, which takes the last of them."""
        if not self._final_fits:
            return super().finished
        ended = self._last is not None and self.generation >= self._last + self._schedule.length
        return ended or self.generation >= self.settings.generations

    @property
    def _final_fits(self) -> bool:
        """Does `search.episodes` allow more than a final? Else there is none."""
        return self.settings.episodes is None or self._final_costs < self.settings.episodes

    @property
    def _final_costs(self) -> int:
        """Deployments of a final."""
        return self._schedule.length * self.settings.in_final(self.problem.worlds)

    def ask(self, count: int = 1) -> list[Solution]:
        """See `Search.ask`: not beyond a round of a final, since the next one depends on it."""
        if not self._asked and not self.finished:
            most = self.settings.episodes if self._final_fits else None
            if most is not None and self._last is None and self.episodes + self._final_costs >= most:
                self._last = self.generation
            count = min(max(1, count), self._stop(self.generation) - self.generation)
        return super().ask(count)

    def _turn(self, generation: int) -> tuple[int, int] | None:
        """Of a final; see `Schedule.turn`."""
        if self.settings.episodes is None:
            return self._schedule.turn(generation)
        return None if self._last is None else self._schedule.round_of(generation - self._last)

    def _stop(self, generation: int) -> int:
        """See `Schedule.stop`."""
        turn = self._turn(generation)
        if turn is None:
            return self._schedule.stop(generation) if self.settings.episodes is None else self.settings.generations
        return generation + turn[0] - turn[1]

    def propose(self, generation: int) -> Solution:
        """As `Slcs2`, or in a final one of the finalists again."""
        turn = self._turn(generation)
        if turn is None:
            return super().propose(generation)
        left, place = turn
        members = {member.generation: member for member in self.members}
        if place == 0:
            known = [members[one] for one in self._round] if self._round else self.members
            ranked = sorted(known, key=lambda member: (-member.fitness, member.generation))
            self._round = [member.generation for member in ranked[:left]]
        chosen = members[self._round[place % len(self._round)]].solution  # fewer are held than there are places
        return again(chosen, generation)

    def trial(self, solution: Solution) -> Trial:
        """In a final, as many for each finalist (`Search.in_final`)."""
        if self._turn(solution.generation) is None:
            return super().trial(solution)
        return self._fixed(solution, self.settings.in_final(self.problem.worlds))

    def consider(self, newcomer: Member) -> Verdict:
        """A final's deployments join those of the solution that was deployed again."""
        turn = self._turn(newcomer.generation)
        if turn is None:
            return super().consider(newcomer)
        members = joined(self.members, newcomer)
        self._acceptance.restore(members, self._acceptance.state())
        if turn == (2, 1):
            self._round = []
        return Verdict(accepted=True, size=len(members))

    def _take(self, newcomer: Member) -> Verdict:
        former = self._best
        verdict = super()._take(newcomer)
        held = self.members
        if former is not None and all(member.generation != former.generation for member in held):
            held.append(former)
        held = [member for member in held if member.evaluation.offset is None]
        self._best = max(held, key=lambda member: (self._surely(member), -member.generation))
        return verdict

    def _surely(self, member: Member) -> float:
        return member.fitness - self.noise.error(member.evaluation.deployments)

    def remember(self) -> dict[str, Any]:
        """The round of a final, and when the last one began, too."""
        return super().remember() | {"round": list(self._round), "last": self._last}

    def recall(self, members: list[Member], kept: dict[str, Any]) -> None:
        """What `remember` gave. Raises InputError if a finalist is not among the members."""
        super().recall(members, kept)
        self._round = [int(one) for one in kept["round"]]
        self._last = None if kept["last"] is None else int(kept["last"])
        if not {*self._round} <= {member.generation for member in members}:
            raise InputError("search: a finalist is not among the members")
