"""A solution's evaluation under way: which deployments are wanted, and which of them count."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.search.evaluation import Deployment, Evaluation, mean_of


def counted(fitnesses: Sequence[float], *, min_deployments: int, max_redeployments: int) -> int | None:
    """How many of the first deployments count, None if more are needed.

    Deployments go on while fewer than `min_deployments` were made, or the mean fitness is > 0 and fewer than
    `max_redeployments` re-deployments (all but the first) were made.
    """
    total = 0.0
    for count, fitness in enumerate(fitnesses, start=1):
        total += fitness
        if count >= min_deployments and (total <= 0 or count > max_redeployments):
            return count
    return None


def raced(
    fitnesses: Sequence[float], *, min_deployments: int, max_redeployments: int, rival: float, margin: float
) -> int | None:
    """How many of the first deployments of a race count, None if more are needed.

    Deployments go on while fewer than `min_deployments` were made, or fewer than `max_redeployments` re-deployments and
    the mean may still be above `rival`: mean + margin / sqrt(deployments) > rival.
    """
    total = 0.0
    for count, fitness in enumerate(fitnesses, start=1):
        total += fitness
        lost = total / count + margin / math.sqrt(count) <= rival
        if count >= min_deployments and (lost or count > max_redeployments):
            return count
    return None


class Trial:
    """One solution's evaluation under way: takes deployments by number in any order, says which are still wanted."""

    def __init__(self, *, min_deployments: int = 1, max_redeployments: int = 5, name: str = "evaluation") -> None:
        """`name` opens the error messages, e.g. 'run 3, generation 12'."""
        if min_deployments < 1 or max_redeployments < 0:
            raise InputError(
                f"min_deployments = {min_deployments}, max_redeployments = {max_redeployments}; "
                "at least 1 and at least 0 are accepted"
            )
        self._min, self._max_re, self._name = min_deployments, max_redeployments, name
        self._held: dict[int, Deployment] = {}

    @property
    def limit(self) -> int:
        """The greatest number of deployments that can count."""
        return max(self._min, self._max_re + 1)

    @property
    def held(self) -> dict[int, Deployment]:
        """Those handed in so far, by number."""
        return dict(self._held)

    def add(self, index: int, deployment: Deployment) -> None:
        """Hand in deployment `index`; it is ignored if beyond the count. Raises InputError on NaN or a wrong index."""
        if index in self._held or not 0 <= index < self.limit:
            raise InputError(f"{self._name}: deployment {index} is here already or is not one of 0..{self.limit - 1}")
        deployment.check(f"{self._name}, deployment {index}")
        self._held[index] = deployment

    def _prefix(self) -> list[Deployment]:
        prefix: list[Deployment] = []
        while len(prefix) in self._held:
            prefix.append(self._held[len(prefix)])
        return prefix

    def _count(self) -> int | None:
        fitnesses = [one.fitness for one in self._prefix()]
        return counted(fitnesses, min_deployments=self._min, max_redeployments=self._max_re)

    @property
    def complete(self) -> bool:
        """True once it is decided which deployments count and all of them are here."""
        return self._count() is not None

    def wanted(self, ahead: int = 0) -> list[int]:
        """Numbers not handed in yet: those certain to count, and up to `ahead` more that may count (speculation)."""
        if self.complete:
            return []
        made = len(self._prefix())
        stop = min(self.limit, max(made + 1, self._min) + ahead)
        return [index for index in range(made, stop) if index not in self._held]

    def result(self) -> Evaluation:
        """The means over the deployments that count. Raises InputError while `complete` is False."""
        count = self._count()
        if count is None:
            raise InputError(f"{self._name}: deployments {self.wanted()} are still wanted")
        return mean_of([self._held[index] for index in range(count)])


class Race(Trial):
    """An evaluation that ends when the solution can hardly be better than its rival: see `raced`."""

    def __init__(
        self, *, rival: float, margin: float, min_deployments: int = 1, max_redeployments: int = 5, name: str
    ) -> None:
        """`rival`: mean fitness of the best so far, -inf for none; `margin`: half width of the interval at one
        deployment, in fitness. Both are fixed when the race begins, so that it can be begun again alike."""
        super().__init__(min_deployments=min_deployments, max_redeployments=max_redeployments, name=name)
        self._rival, self._margin = rival, margin

    def _count(self) -> int | None:
        return raced(
            [one.fitness for one in self._prefix()],
            min_deployments=self._min,
            max_redeployments=self._max_re,
            rival=self._rival,
            margin=self._margin,
        )


class WorldRace(Trial):
    """A race through many worlds: the solution is compared with its rival in the worlds where both were deployed.

    Worlds come in a fixed order. The race ends when the mean difference is at most -margin / sqrt(worlds); what the
    rival came to in the other worlds then stands for what is not known (`Evaluation.offset`).
    """

    def __init__(self, *, rival: np.ndarray | None, margin: float, kinds: int, worlds: int, name: str) -> None:
        """`rival`: float64[W], mean fitness of the best so far in each world; None for none. `kinds`: deployments that
        are made in any case. `margin` as in `Race`."""
        super().__init__(min_deployments=worlds, max_redeployments=worlds - 1, name=name)
        self._rival, self._margin, self._kinds = rival, margin, kinds

    def _count(self) -> int | None:
        total = 0.0
        for count, one in enumerate(self._prefix(), start=1):
            if count >= self.limit:
                return count
            if self._rival is None:
                continue
            total += one.fitness - self._rival[count - 1]
            if count >= self._kinds and total / count + self._margin / math.sqrt(count) <= 0:
                return count
        return None

    def wanted(self, ahead: int = 0) -> list[int]:
        """See `Trial`: only the next is certain, or the rest of the kinds, or without a rival all."""
        if self.complete:
            return []
        made = len(self._prefix())
        certain = self.limit if self._rival is None else max(made + 1, self._kinds)
        return [index for index in range(made, min(self.limit, certain + ahead)) if index not in self._held]

    def result(self) -> Evaluation:
        """See `Trial`; with an offset if it ended early."""
        found = super().result()
        count = found.deployments
        if self._rival is None or count == self.limit:
            return found
        return replace(found, offset=float(self._rival.mean() - self._rival[:count].mean()))
