"""Evaluation of a solution: how many deployments count, and their means (paper, Evaluation and Re-Evaluation).

[n, R] = agents, rules. Deployments are numbered 0, 1, ... and may be computed side by side and arrive in any order;
which of them count does not depend on that, so speculation never changes a result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.results.figures import Figures, check_numbers


@dataclass(frozen=True, eq=False, kw_only=True)
class Deployment:
    """What one episode of a solution measured."""

    fitness: float  # by the task
    delivered: int  # packets at the sink, p_s
    steps: int  # time-steps done, T_s
    contribution: np.ndarray  # int[n] delivered packets that the agent had held
    figures: Figures | None = None  # of every rule [n, R]; None for a policy without rules
    measures: Mapping[str, Any] = field(default_factory=dict)  # what the task took from the last state, by name

    def check(self, name: str = "deployment") -> None:
        """Raise InputError naming field, agent and rule where a shape is wrong or a number not finite or negative."""
        check_measured(name, self.fitness, self.contribution, self.figures)


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluation:
    """Means over the deployments that count. Contributions are kept as sums: comparing integers is exact."""

    fitnesses: tuple[float, ...]  # of each deployment, in order
    delivered: float  # mean packets at the sink
    steps: float  # mean time-steps
    contribution_sum: np.ndarray  # int64[n] summed over the deployments
    figures: Figures  # means, float32[n, R]
    offset: float | None = None  # of deployments in some of many worlds: what the mean would be more in all of them

    @property
    def deployments(self) -> int:
        return len(self.fitnesses)

    @property
    def fitness(self) -> float:
        """Mean fitness, with `offset`."""
        return sum(self.fitnesses) / len(self.fitnesses) + (self.offset or 0.0)

    def by_world(self, worlds: int) -> np.ndarray:
        """float64[W]: mean fitness in each world, of rounds through all of them."""
        return np.array(self.fitnesses).reshape(-1, worlds).mean(axis=0)

    @property
    def contribution(self) -> np.ndarray:
        """float64[n] mean contribution of each agent."""
        return self.contribution_sum / self.deployments

    @property
    def used(self) -> np.ndarray:
        """bool[n, R] rules that were in an action set in any deployment."""
        return self.figures.usage > 0

    def check(self, agents: int, rules: int, name: str = "evaluation") -> None:
        """Raise InputError if it does not fit a solution of `agents` x `rules`, or if it is not finite."""
        if not self.fitnesses:
            raise InputError(f"{name}: no deployment; at least one is required")
        if self.figures.shape != (agents, rules):
            raise InputError(f"{name}: strength has shape {self.figures.shape}; ({agents}, {rules}) is required")
        check_measured(name, self.fitness, self.contribution_sum, self.figures)


def check_measured(name: str, fitness: float, contribution: np.ndarray, figures: Figures | None) -> None:
    """Raise InputError naming what is not finite, negative, or of another shape than [n] and [n, R]."""
    if not np.isfinite(fitness):
        raise InputError(f"{name}: fitness is {fitness}; a finite number is required")
    if figures is not None:
        figures.check(name)
    agents = np.shape(contribution)[:1] if figures is None else figures.shape[:1]
    check_numbers(name, "contribution", contribution, agents, negative=False)


def mean_of(deployments: Sequence[Deployment]) -> Evaluation:
    """The evaluation in which exactly these deployments count."""
    if not deployments:
        raise InputError("deployments: none given; at least one is required")
    figures = [one.figures for one in deployments if one.figures is not None]
    if len(figures) != len(deployments):
        raise InputError("deployments: one has no figures of rules; a search of rule-sets requires them")
    count = len(deployments)
    return Evaluation(
        fitnesses=tuple(float(one.fitness) for one in deployments),
        delivered=sum(int(one.delivered) for one in deployments) / count,
        steps=sum(int(one.steps) for one in deployments) / count,
        contribution_sum=np.stack([one.contribution for one in deployments]).sum(axis=0, dtype=np.int64),
        figures=Figures.mean_of(figures),
    )


def together(one: Evaluation, other: Evaluation) -> Evaluation:
    """Two evaluations of one solution as a single one; the deployments of the first come first.

    Of one that was made in some of many worlds nothing is kept: the other counts alone.
    """
    if one.offset is not None:
        return other
    first, second = one.deployments, other.deployments
    count = first + second

    def mean(a: Any, b: Any) -> Any:
        return (a * first + b * second) / count

    arrays = {
        name: mean(array.astype(np.float64), other.figures.arrays()[name].astype(np.float64)).astype(np.float32)
        for name, array in one.figures.arrays().items()
    }
    return Evaluation(
        fitnesses=one.fitnesses + other.fitnesses,
        delivered=mean(one.delivered, other.delivered),
        steps=mean(one.steps, other.steps),
        contribution_sum=one.contribution_sum + other.contribution_sum,
        figures=Figures(**arrays),
    )
