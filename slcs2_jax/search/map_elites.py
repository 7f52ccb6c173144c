"""MAP-Elites: the fittest solution of each niche (Mouret and Clune, Illuminating search spaces, arXiv 1504.04909)."""

from __future__ import annotations

from typing import Any

from slcs2_jax.search.member import Member
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.sharing import sharing

BINS = 10  # to each axis

Niche = tuple[int, ...]


def niche_of(member: Member) -> Niche:
    """The cell of a grid of `BINS` x `BINS` over how the work is shared."""
    return tuple(min(int(BINS * value), BINS - 1) for value in sharing(member.evaluation))


class MapElites:
    """A newcomer takes its niche if it is empty or held by one that is less fit."""

    def __init__(self, problem: Problem) -> None:
        """Nothing of the problem matters."""
        self._elites: dict[Niche, Member] = {}

    def members(self) -> list[Member]:
        """One of each niche that was reached, the oldest first."""
        return sorted(self._elites.values(), key=lambda member: member.generation)

    def consider(self, newcomer: Member) -> Verdict:
        """See `Acceptance`."""
        niche = niche_of(newcomer)
        former = self._elites.get(niche)
        if former is not None and newcomer.fitness <= former.fitness:
            return Verdict(accepted=False, size=len(self._elites))
        self._elites[niche] = newcomer
        return Verdict(removed=() if former is None else (former.generation,), size=len(self._elites))

    def state(self) -> dict[str, Any]:
        """Nothing besides the members is remembered."""
        return {}

    def restore(self, members: list[Member], state: dict[str, Any]) -> None:
        """Hold exactly these members."""
        self._elites = {niche_of(member): member for member in members}
