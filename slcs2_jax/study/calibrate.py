"""The calibration study's computing: every point in every cell, by cheap estimators."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from slcs2_jax.config import Settings
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.results import Progress
from slcs2_jax.results.arm import Cell, cell_of
from slcs2_jax.results.documents import checksum
from slcs2_jax.results.files import write_text
from slcs2_jax.study.calibration import Estimate, Fit, Notebook, Point, fits, fits_table, points
from slcs2_jax.study.experiment import settings_with

FOLDER = "calibration"  # below run_dir
BEHAVIOUR = "designed"

_NODE = ("deployments", "samples", "only", "candidates", "levels", "joint")


@dataclass(frozen=True, eq=False)
class Task:
    """The study in one cell.

    Attributes:
        config: the cell's composed settings.
        node: the study's own, as conf/experiment/calibration.yaml has them.
        root: folder of the study, below which it keeps its estimates.
    """

    config: Mapping[str, Any]
    node: Mapping[str, Any]
    root: str

    @cached_property
    def settings(self) -> Settings:
        """At the defaults of the study."""
        return settings_with(self.config, {})

    @property
    def cell(self) -> Cell:
        """Where."""
        return cell_of(self.settings)

    @property
    def folder(self) -> Path:
        """Of estimates, table and figure."""
        return Path(self.root) / FOLDER

    @property
    def sizes(self) -> dict[str, Any]:
        """What an estimate depends on beside its point: everything but where it is computed and kept."""
        kept = {key: value for key, value in self.config.items() if key not in ("compute", "checkpoint")}
        sizes = {key: self.config[key] for key in ("seed", "instances", "generations")}
        return sizes | {"deployments": self.node["deployments"], "settings": checksum(kept)}

    @cached_property
    def points(self) -> list[Point]:
        """What is tried. Raises InputError if one point is impossible."""
        found = []
        for point in points(_levels(self.node), dict(self.node["joint"]), self.node["samples"], _candidates(self.node)):
            try:
                settings = settings_with(self.config, dict(point.values))
            except InputError as error:
                raise InputError(f"calibration: {point.name}: {error}") from None
            if point.kind != "level" or settings != self.settings:  # else it is the defaults again
                found.append(point)
        return found


def _levels(node: Mapping[str, Any]) -> dict[str, Any]:
    """The levels that are asked for; refuses whatever is wrong in the node beside them."""
    unknown = sorted(set(node) - set(_NODE))
    if unknown:
        raise refuse("setting", f"calibration.{unknown[0]}", "one of calibration." + ", calibration.".join(_NODE))
    for name in ("samples", "deployments"):
        value, least = node[name], 0 if name == "samples" else 1
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise refuse(f"calibration.{name}", value, f"a whole number >= {least}")
    levels, only = dict(node["levels"]), node["only"]
    if only is None:
        return levels
    if not isinstance(only, list) or not set(only) <= set(levels):
        raise refuse("calibration.only", only, "null or a list of settings from calibration.levels")
    return {name: values for name, values in levels.items() if name in only}


def _candidates(node: Mapping[str, Any]) -> list[dict[str, Any]]:
    given = node["candidates"]
    if not isinstance(given, list) or not all(isinstance(one, dict) and one for one in given):
        raise refuse("calibration.candidates", given, "a list of mappings of settings, [{swarm.speed: 4}]")
    return given


def calibrate(tasks: Sequence[Task]) -> None:
    """Estimate every point in these cells, and note each as soon as it is there."""
    notebook = Notebook(tasks[0].folder)
    going = _missing(notebook, tasks)
    if not going:
        return
    from slcs2_jax import runtime

    runtime.configure(tasks[0].settings.compute)
    with Progress(len(going), label="point") as report:
        for number, (point, lacking) in enumerate(going):
            report.note(f"{number + 1}/{len(going)}: {point.name}")
            runs = [settings_with(task.config, dict(point.values)) for task in lacking]
            for task, estimate in zip(lacking, _estimates(runs, lacking[0].node["deployments"]), strict=True):
                notebook.add(task.cell, point, estimate, task.sizes)


def _missing(notebook: Notebook, tasks: Sequence[Task]) -> list[tuple[Point, list[Task]]]:
    """Points with the cells that lack them."""
    known = [(task, notebook.read(task.cell, task.sizes)) for task in tasks]
    lacking = [(point, [task for task, values in known if point.values not in values]) for point in tasks[0].points]
    return [(point, here) for point, here in lacking if here]


def _estimates(runs: Sequence[Settings], deployments: int) -> list[Estimate]:
    from slcs2_jax.policy.decision_list import load_decision_list
    from slcs2_jax.running import driver

    designed = driver.deploy_in_runs(runs, load_decision_list(BEHAVIOUR), deployments=deployments)
    short = [
        dataclasses.replace(one, run_dir=None, search=dataclasses.replace(one.search, fresh_deployments=1))
        for one in runs  # nobody looks at the winner's fresh deployments
    ]
    return [
        Estimate(
            designed=_mean([one.fitness for instance in instances for one in instance]),
            evolved=_mean([one.best_fitness for one in summary.instances]),
        )
        for instances, summary in zip(designed, driver.evolve(short), strict=True)
    ]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


@dataclass(frozen=True)
class Concluded:
    """What all that has been estimated comes to.

    Attributes:
        table: the file of the table.
        drawn: is there a figure beside it? It needs matplotlib.
        fits: of every point, the best first.
    """

    table: Path
    drawn: bool
    fits: tuple[Fit, ...]


def conclude(tasks: Sequence[Task]) -> Concluded:
    """Write the table and the figure of all that has been estimated."""
    first = tasks[0]
    notebook = Notebook(first.folder)
    found = fits(first.points, {task.cell: notebook.read(task.cell, task.sizes) for task in tasks})
    table = fits_table(found)
    write_text(first.folder / "calibration.csv", table.csv())
    write_text(first.folder / "calibration.md", "# Calibration study\n\n" + table.markdown())
    try:
        from slcs2_jax.looking import drawing
        from slcs2_jax.study import figure
    except ImportError:
        drawn = False
    else:
        drawing.save(lambda: figure.calibration_figure(found), first.folder / "calibration")
        drawn = True
    ranked = sorted(found, key=lambda fit: math.inf if fit.misfit is None else fit.misfit)
    return Concluded(first.folder / "calibration.md", drawn, tuple(ranked))
