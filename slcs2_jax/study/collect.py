"""Every result below a folder: one for each instance of each run, with its curve and its fresh figure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.door import telling_damage
from slcs2_jax.config.field import show
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.results import FinishedRun, read_run
from slcs2_jax.results.progress import counted
from slcs2_jax.results.run_folder import folders_with_config
from slcs2_jax.study.arm import COMPARED, Cell, arm_of, cell_of

# How far a run goes, which the report treats by itself; and of the settings that are no part of the model the one that
# figures depend on.
_GENERATIONS, _FRESH = "generations", "search.fresh_deployments"
EVOLVED = "evolve"  # kind of a run in its record
CONTROLLER = "controller"  # in the record of an evaluation: the behaviour made by hand
DEPLOYED = "fitness"  # in its summary: of each deployment in its one instance
# What environment= and range= set: these differ between cells, never within one.
_OF_THE_CELL = frozenset(
    {"environment", "range", "world.buildings", "world.jammer", "world.distance", "world.time_limit"}
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Outcome:
    """One instance of one run.

    Attributes:
        curve: float64[generations], best fitness so far; empty for a behaviour that does not evolve.
        fresh: mean fitness of the winner over its fresh deployments; None while the run has not ended.
        deployments: float64[...], fitness of each deployment of a behaviour that does not evolve; empty for others.
        planned: generations that its configuration asks for; 0 for a behaviour that does not evolve.
        evaluations, env_steps, seconds: episodes of the search, their time-steps, and its share of the computing time;
            0 while the run has not ended.
    """

    arm: str
    cell: Cell
    seed: int
    curve: NDArray[np.float64]
    fresh: float | None
    deployments: NDArray[np.float64]
    planned: int
    evaluations: int
    env_steps: int
    seconds: float
    settings: Settings
    record: Mapping[str, Any]
    folder: Path

    @property
    def evolves(self) -> bool:
        """Is it the result of a search?"""
        return self.planned > 0

    def best(self, generations: int) -> float | None:
        """The paper's figure after so many generations, or of a designed behaviour the mean of its deployments."""
        if not self.evolves:
            return float(self.deployments.mean()) if len(self.deployments) else None
        return float(self.curve[generations - 1]) if 1 <= generations <= len(self.curve) else None

    def fresh_after(self, generations: int) -> float | None:
        """Mean over fresh deployments, if its search ended after so many generations."""
        if not self.evolves:
            return self.best(generations)
        return self.fresh if len(self.curve) == generations else None


def collect(folder: str | Path, passed: list[str] | None = None) -> list[Outcome]:
    """All results in a folder and below it, in a fixed order.

    Args:
        folder: that of an experiment, or any with runs in it; links in it are not followed.
        passed: gets a line for each folder that was passed over, and why.

    Raises:
        InputError: no folder, no run in it, a damaged one, runs that cannot be compared, or one that is there twice.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError(f"folder={show(str(folder))}: no such folder; accepted is a folder with runs of slcs2")
    outcomes: list[Outcome] = []
    for place in counted(list(folders_with_config(root, passed)), "runs read:"):
        run = read_run(place)
        if run.record.get("kind") == EVOLVED or (CONTROLLER in run.record and DEPLOYED in (run.summary or {})):
            outcomes += _outcomes(run)
        elif passed is not None:
            passed.append(f"{place}: is an evaluation of something that evolved elsewhere")
    if not outcomes:
        raise InputError(f"folder={show(str(folder))}: holds no run; accepted is a folder with runs of slcs2")
    if not any(len(one.curve) or len(one.deployments) for one in outcomes):
        raise InputError(
            f"folder={show(str(folder))}: no run in it has finished a generation; accepted is a folder with results"
        )
    refuse_mixed(outcomes)
    _refuse_twice(outcomes)
    return outcomes


def refuse_mixed(outcomes: Sequence[Outcome]) -> None:
    """Raise InputError naming the setting in which two runs differ that must not."""
    for section, field in settings_fields():
        no_matter = field.doc.status == "run" and field.name != _FRESH
        if no_matter or field.name == _GENERATIONS or field.name in COMPARED:
            continue
        first: dict[Any, Outcome] = {}
        for one in outcomes:
            holder = getattr(one.settings, section) if section else one.settings
            value = getattr(holder, field.attribute)
            group = one.cell if field.name in _OF_THE_CELL else None
            other = first.setdefault(group, one)
            reference = getattr(getattr(other.settings, section) if section else other.settings, field.attribute)
            if value != reference:
                raise InputError(
                    f"{field.name}: {show(reference)} in {other.folder} and {show(value)} in {one.folder}; "
                    "accepted are runs that agree in it"
                )


def _refuse_twice(outcomes: Iterable[Outcome]) -> None:
    seen: dict[tuple[str, Cell, int], Outcome] = {}
    for one in outcomes:
        other = seen.setdefault((one.arm, one.cell, one.seed), one)
        if other is not one:
            raise InputError(
                f"seed={one.seed}: {one.arm} in the {one.cell.title} world is both in {other.folder} and in "
                f"{one.folder}; accepted is one run of each instance"
            )


def _outcomes(run: FinishedRun) -> list[Outcome]:
    with telling_damage(f"{run.path}: rows or summary without a figure that each must have"):
        best = {(row["instance"], row["generation"]): float(row["best"]) for row in run.rows}
        return [_outcome(run, instance, best) for instance in range(run.settings.instances)]


def _outcome(run: FinishedRun, instance: int, best: Mapping[tuple[int, int], float]) -> Outcome:
    settings, summary = run.settings, run.summary or {}
    evolves = run.record["kind"] == EVOLVED
    curve: list[float] = []
    while (instance, len(curve)) in best:  # up to the first gap
        curve.append(best[instance, len(curve)])
    ended = summary["instances"][instance] if evolves and summary else {}
    steps = int(ended.get("env_steps", 0))
    rate = float((run.timing or {}).get("env_steps_per_second", 0.0))  # of all runs that shared the batch
    return Outcome(
        arm=arm_of(settings, run.record.get(CONTROLLER)),
        cell=cell_of(settings),
        seed=settings.seed + instance,
        curve=np.array(curve, dtype=np.float64),
        fresh=ended.get("fresh_mean"),
        deployments=np.array(summary.get(DEPLOYED, []), dtype=np.float64),
        planned=settings.search.generations if evolves else 0,
        evaluations=int(ended.get("evaluations", 0)),
        env_steps=steps,
        seconds=steps / rate if rate else 0.0,
        settings=settings,
        record=run.record,
        folder=run.path,
    )
