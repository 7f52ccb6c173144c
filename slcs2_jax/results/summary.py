"""What a finished run or evaluation comes to: the contents of summary.json."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
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
        generations: how many it made.
        best_fitness: greatest mean fitness of any solution that the search evaluated.
        fresh_mean, fresh_sd: mean and standard deviation of the winner's fitness over its fresh deployments.
        evaluations: episodes run by the search.
        env_steps: time-steps of those episodes.
        fresh_failed: share of the winner's fresh deployments that delivered nothing; None where it was not kept.
    """

    seed: int
    generations: int
    best_fitness: float
    fresh_mean: float
    fresh_sd: float
    evaluations: int
    env_steps: int
    fresh_failed: float | None = None


@dataclass(frozen=True, kw_only=True)
class RunSummary(_Finite):
    """One evolution run, all its instances; `run_dir` is "" where nothing was written.

    `generations` is what was asked for. The figures below `instances` are of the machine and no part of the results; 0
    where they are not known. All but the first are those of the last session and of all runs that shared the batch.

    Attributes:
        wall_seconds: time of all sessions together.
        env_steps_per_second: only time-steps of episodes that counted.
        compile_seconds: compiling, or loading what was compiled before.
        host_share: share of the time, compiling apart, in which the devices waited for the host.
        useful_share: share of all slots' time-steps that counted.
    """

    run_dir: str
    generations: int
    instances: tuple[InstanceSummary, ...]
    wall_seconds: float = 0.0
    env_steps_per_second: float = 0.0
    compile_seconds: float = 0.0
    host_share: float = 0.0
    useful_share: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """The results as written to summary.json: the same for equal runs, wherever and however they were made."""
        return {"generations": self.generations, "instances": [asdict(instance) for instance in self.instances]}

    def timing(self) -> dict[str, float]:
        """The figures of the machine, as written to timing.json."""
        return {name: float(getattr(self, name)) for name in _TIMING}

    @classmethod
    def from_json(cls, run_dir: str, results: Mapping[str, Any], timing: Mapping[str, Any] | None) -> RunSummary:
        """The summary of a run that has ended, from what its folder holds."""
        return cls(
            run_dir=run_dir,
            generations=results["generations"],
            instances=tuple(InstanceSummary(**instance) for instance in results["instances"]),
            **{name: (timing or {}).get(name, 0.0) for name in _TIMING},
        )


_TIMING = ("wall_seconds", "env_steps_per_second", "compile_seconds", "host_share", "useful_share")


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
        """The results as written to summary.json."""
        return {
            "fitness_mean": self.mean,
            "fitness_sd": self.sd,
            "scenarios": [asdict(scenario) for scenario in self.scenarios],
        }

    def timing(self) -> dict[str, float]:
        """The figures of the machine, as written to timing.json."""
        return {"wall_seconds": self.wall_seconds, "env_steps_per_second": self.env_steps_per_second}


def spread(values: Sequence[float]) -> float:
    """Sample standard deviation; 0 for fewer than two values."""
    return statistics.stdev(values) if len(values) > 1 else 0.0
