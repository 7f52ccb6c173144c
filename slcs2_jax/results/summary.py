"""What a finished run or evaluation comes to: the contents of summary.json."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any


class _Finite:
    """Base of the summaries: NaN and infinity never enter a result silently."""

    def __post_init__(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f"{field.name}={value} in a summary: every figure must be finite")


@dataclass(frozen=True, kw_only=True)
class InstanceSummary(_Finite):
    """One instance of an evolution run.

    Attributes:
        seed: the instance's seed.
        best_fitness: greatest mean fitness of any solution that the search evaluated.
        fresh_mean, fresh_sd: mean and standard deviation of the winner's fitness over its fresh deployments.
        evaluations: episodes run by the search.
        env_steps: time-steps of those episodes.
    """

    seed: int
    best_fitness: float
    fresh_mean: float
    fresh_sd: float
    evaluations: int
    env_steps: int


@dataclass(frozen=True, kw_only=True)
class RunSummary(_Finite):
    """One evolution run, all its instances; `run_dir` is "" where nothing was written."""

    run_dir: str
    instances: tuple[InstanceSummary, ...]
    wall_seconds: float
    env_steps_per_second: float

    def to_json(self) -> dict[str, Any]:
        """Plain values as written to summary.json (without the folder, which the file is in)."""
        return {
            "instances": [asdict(instance) for instance in self.instances],
            "wall_seconds": self.wall_seconds,
            "env_steps_per_second": self.env_steps_per_second,
        }


@dataclass(frozen=True, kw_only=True)
class ScenarioSummary(_Finite):
    """A saved solution in one scenario: means over the deployments there."""

    seed: int
    fitness: float
    fitness_sd: float
    delivered: float
    steps: float
    deployments: int


@dataclass(frozen=True, kw_only=True)
class EvaluationSummary(_Finite):
    """A saved solution over scenarios."""

    scenarios: tuple[ScenarioSummary, ...]
    wall_seconds: float
    env_steps_per_second: float

    @property
    def mean(self) -> float:
        """Mean over scenarios of the mean fitness in each."""
        return statistics.fmean(scenario.fitness for scenario in self.scenarios)

    @property
    def sd(self) -> float:
        """Standard deviation of those means between scenarios; 0 for one."""
        return spread([scenario.fitness for scenario in self.scenarios])

    def to_json(self) -> dict[str, Any]:
        """Plain values as written to summary.json."""
        return {
            "fitness_mean": self.mean,
            "fitness_sd": self.sd,
            "scenarios": [asdict(scenario) for scenario in self.scenarios],
            "wall_seconds": self.wall_seconds,
            "env_steps_per_second": self.env_steps_per_second,
        }


def spread(values: Sequence[float]) -> float:
    """Sample standard deviation; 0 for fewer than two values."""
    return statistics.stdev(values) if len(values) > 1 else 0.0
