"""How much deployments of one and the same solution differ, measured as a search goes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

# What is taken for granted before anything is measured: as much as so many differences of this standard deviation.
_FIRST_GUESS, _WEIGHT = 0.15, 2


class Noise:
    """The standard deviation within solutions, pooled over all that were deployed more than once."""

    def __init__(self) -> None:
        self._squares, self._freedom = 0.0, 0

    def add(self, fitnesses: Sequence[float]) -> None:
        """Take in the deployments of one solution."""
        mean = math.fsum(fitnesses) / len(fitnesses)
        self._squares += math.fsum((fitness - mean) ** 2 for fitness in fitnesses)
        self._freedom += len(fitnesses) - 1

    @property
    def deviation(self) -> float:
        """Of one deployment, in fitness; above 0."""
        return math.sqrt((self._squares + _WEIGHT * _FIRST_GUESS**2) / (self._freedom + _WEIGHT))

    def error(self, deployments: int) -> float:
        """Standard error of the mean of so many."""
        return self.deviation / math.sqrt(deployments)

    def state(self) -> dict[str, Any]:
        """What was measured, JSON-able."""
        return {"squares": self._squares, "freedom": self._freedom}

    def restore(self, state: dict[str, Any]) -> None:
        """Become what state() was taken from."""
        self._squares, self._freedom = float(state["squares"]), int(state["freedom"])
