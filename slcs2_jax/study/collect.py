"""Every result below a folder: one for each instance of each run, with its curve and its fresh figure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.door import telling_damage
from slcs2_jax.config.field import show
from slcs2_jax.results import FinishedRun, read_run
from slcs2_jax.results.arm import Cell, arm_at, arm_of, cell_of
from slcs2_jax.results.progress import counted
from slcs2_jax.results.run_folder import folders_with_config
from slcs2_jax.study.factor import Point, factors, point_of, point_text

EVOLVED = "evolve"  # kind of a run in its record
POLICY = "policy"  # in the record of an evaluation: what was deployed, if it was no saved solution
_FORMER_POLICY = "controller"  # what that was called
DEPLOYED = "fitness"  # in its summary: of each deployment in its one instance


@dataclass(frozen=True, eq=False, kw_only=True)
class Outcome:
    """One instance of one run.

    Attributes:
        algorithm: its arm's name without `point`.
        point: the factors of all results of the folder in which it is not at their base, with its values.
        curve: float64[generations], best fitness so far; empty for a behaviour that does not evolve.
        episodes, steps: float64[generations], what the search had spent by then: deployments, and their time-steps.
        fresh: mean fitness of the winner over its fresh deployments; None while the run has not ended.
        deployments: float64[...], fitness of each deployment of a behaviour that does not evolve; empty for others.
        failed: share of the deployments behind the fresh figure that delivered nothing; None where that is not kept.
        planned: generations that its configuration asks for; 0 for a behaviour that does not evolve.
        evaluations, env_steps, seconds: episodes of the search, their time-steps, and its share of the computing time;
            0 while the run has not ended.
    """

    algorithm: str
    cell: Cell
    seed: int
    curve: NDArray[np.float64]
    episodes: NDArray[np.float64]
    steps: NDArray[np.float64]
    fresh: float | None
    deployments: NDArray[np.float64]
    failed: float | None
    planned: int
    evaluations: int
    env_steps: int
    seconds: float
    settings: Settings
    record: Mapping[str, Any]
    folder: Path
    point: Point = ()

    @property
    def arm(self) -> str:
        """What it is compared as."""
        return arm_at(self.algorithm, point_text(self.point))

    @property
    def evolves(self) -> bool:
        """Is it the result of a search?"""
        return self.planned > 0

    def best(self, generations: int | None) -> float | None:
        """The paper's figure after so many generations, None: where the search ended; or of a designed behaviour the
        mean of its deployments."""
        if not self.evolves:
            return float(self.deployments.mean()) if len(self.deployments) else None
        if generations is None:
            generations = 0 if self.fresh is None else len(self.curve)
        return float(self.curve[generations - 1]) if 1 <= generations <= len(self.curve) else None

    def fresh_after(self, generations: int | None) -> float | None:
        """Mean over fresh deployments, if its search ended after so many generations; None: after any number."""
        if not self.evolves:
            return self.best(generations)
        return self.fresh if generations in (None, len(self.curve)) else None


def policy_of(record: Mapping[str, Any]) -> str | None:
    """The policy that a run deployed, by its name or path; None if it evolved rules, or evaluated a saved solution."""
    return record.get(POLICY, record.get(_FORMER_POLICY))


def collect(folder: str | Path, passed: list[str] | None = None) -> list[Outcome]:
    """All results in a folder and below it, in a fixed order.

    Args:
        folder: that of an experiment, or any with runs in it; links in it are not followed.
        passed: gets a line for each folder that was passed over, and why.

    Raises:
        InputError: no folder, no run in it, a damaged one, or one that is there twice.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError(f"folder={show(str(folder))}: no such folder; accepted is a folder with runs of slcs2")
    outcomes: list[Outcome] = []
    for place in counted(list(folders_with_config(root, passed)), "runs read:"):
        run = read_run(place)
        if run.record.get("kind") == EVOLVED or (policy_of(run.record) is not None and DEPLOYED in (run.summary or {})):
            outcomes += _outcomes(run)
        elif passed is not None:
            passed.append(f"{place}: is an evaluation of something that evolved elsewhere")
    if not outcomes:
        raise InputError(f"folder={show(str(folder))}: holds no run; accepted is a folder with runs of slcs2")
    if not any(len(one.curve) or len(one.deployments) for one in outcomes):
        raise InputError(
            f"folder={show(str(folder))}: no run in it has finished a generation; accepted is a folder with results"
        )
    varied = factors(one.settings for one in outcomes)
    outcomes = [replace(one, point=point_of(one.settings, varied)) for one in outcomes]
    _refuse_twice(outcomes)
    return outcomes


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
        rows = {
            (row["instance"], row["generation"]): (
                float(row["best"]),
                row["deployments"],
                row["deployments"] * row["steps"],
            )
            for row in run.rows
        }
        return [_outcome(run, instance, rows) for instance in range(run.settings.instances)]


def _outcome(run: FinishedRun, instance: int, rows: Mapping[tuple[int, int], tuple[float, int, float]]) -> Outcome:
    settings, summary = run.settings, run.summary or {}
    evolves = run.record["kind"] == EVOLVED
    told: list[tuple[float, int, float]] = []
    while (instance, len(told)) in rows:  # up to the first gap
        told.append(rows[instance, len(told)])
    curve, episodes, spent = np.array(told, dtype=np.float64).reshape(-1, 3).T
    ended = summary["instances"][instance] if evolves and summary else {}
    steps = int(ended.get("env_steps", 0))
    deployments = np.array(summary.get(DEPLOYED, []), dtype=np.float64)
    failed = ended.get("fresh_failed") if evolves else float((deployments <= -1).mean()) if len(deployments) else None
    rate = float((run.timing or {}).get("env_steps_per_second", 0.0))  # of all runs that shared the batch
    return Outcome(
        algorithm=arm_of(settings, policy_of(run.record)),
        cell=cell_of(settings),
        seed=settings.seed + instance,
        curve=curve,
        episodes=episodes.cumsum(),
        steps=spent.cumsum(),
        fresh=ended.get("fresh_mean"),
        deployments=deployments,
        failed=failed,
        planned=settings.search.generations if evolves else 0,
        evaluations=int(ended.get("evaluations", 0)),
        env_steps=steps,
        seconds=steps / rate if rate else 0.0,
        settings=settings,
        record=run.record,
        folder=run.path,
    )
