"""Adaptive iteration limited threshold accepting (AILTA; Misir et al. 2010), the ablation without novelty."""

from __future__ import annotations

from typing import Any

from slcs2_jax.config.field import refuse
from slcs2_jax.search.member import Member
from slcs2_jax.search.novelty import novelty
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem


class Ailta:
    """One current solution. A newcomer replaces it if it is at least as fit, or if, after `rejections` rejections in
    a row, its fitness is at least the best ever seen less the threshold theta.

    theta = min(threshold_max, threshold * (1 + stale // patience)), stale = newcomers since the last new best, without
    the one considered now. Any acceptance ends the row of rejections.
    """

    def __init__(self, problem: Problem) -> None:
        """Rejections, threshold, its maximum and patience are `search.ailta_...`."""
        settings = problem.settings
        if settings.ailta_threshold > settings.ailta_threshold_max:
            most = f"a number up to search.ailta_threshold_max={settings.ailta_threshold_max:g}"
            raise refuse("search.ailta_threshold", settings.ailta_threshold, most)
        self._limit, self._patience = settings.ailta_rejections, settings.ailta_patience
        self._threshold, self._threshold_max = settings.ailta_threshold, settings.ailta_threshold_max
        self._current: Member | None = None
        self._best = float("-inf")
        self._rejected = 0  # rejections in a row
        self._stale = 0  # newcomers since the last new best

    def members(self) -> list[Member]:
        """The current solution, if there is one yet."""
        return [] if self._current is None else [self._current]

    @property
    def threshold(self) -> float:
        """theta for the next newcomer."""
        return min(self._threshold_max, self._threshold * (1 + self._stale // self._patience))

    def consider(self, newcomer: Member) -> Verdict:
        """Make the newcomer the current solution or reject it."""
        current, theta = self._current, self.threshold
        distance = novelty(newcomer.solution.ids, current.solution.ids) if current else float("nan")
        accepted = current is None or newcomer.fitness >= current.fitness
        if not accepted:
            accepted = self._rejected >= self._limit and newcomer.fitness >= self._best - theta
        if newcomer.fitness > self._best:
            self._best, self._stale = newcomer.fitness, 0
        else:
            self._stale += 1
        if not accepted:
            self._rejected += 1
            return Verdict(accepted=False, novelty=distance, removed=(), size=1)
        self._rejected, self._current = 0, newcomer
        removed = () if current is None else (current.generation,)
        return Verdict(accepted=True, novelty=distance, removed=removed, size=1)

    def state(self) -> dict[str, Any]:
        """Best fitness and counters."""
        best = self._best if self._current else None
        return {"best": best, "rejected": self._rejected, "stale": self._stale}

    def restore(self, members: list[Member], state: dict[str, Any]) -> None:
        """Become what `members()` and `state()` were taken from."""
        self._current = members[0] if members else None
        self._best = float("-inf") if state["best"] is None else float(state["best"])
        self._rejected, self._stale = int(state["rejected"]), int(state["stale"])
