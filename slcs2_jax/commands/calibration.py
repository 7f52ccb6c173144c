"""slcs2 experiment calibration: every point of the study in every cell, by cheap estimators."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.study.arm import Cell
    from slcs2_jax.study.calibration import Estimate, Point

FOLDER = "calibration"  # below run_dir
BEHAVIOUR = "designed"

_NODE = ("deployments", "samples", "only", "candidates", "levels", "joint")

Split = tuple[dict[str, Any], dict[str, Any]]  # a cell's settings, and what is the experiment's own


def tried(config: Mapping[str, Any], node: Mapping[str, Any]) -> list[Point]:
    """The points of the study; raises InputError if one of them is impossible."""
    from slcs2_jax.study.calibration import points
    from slcs2_jax.study.experiment import settings_with

    unknown = sorted(set(node) - set(_NODE))
    if unknown:
        raise refuse("setting", f"calibration.{unknown[0]}", "one of calibration." + ", calibration.".join(_NODE))
    levels, joint, only = dict(node["levels"]), dict(node["joint"]), node["only"]
    if only is not None:
        if not isinstance(only, list) or not set(only) <= set(levels):
            raise refuse("calibration.only", only, "null or a list of settings from calibration.levels")
        levels = {name: values for name, values in levels.items() if name in only}
    for name in ("samples", "deployments"):
        value, least = node[name], 0 if name == "samples" else 1
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise refuse(f"calibration.{name}", value, f"a whole number >= {least}")
    own, found = settings_with(config, {}), []
    for point in points(levels, joint, node["samples"], _candidates(node["candidates"])):
        try:
            settings = settings_with(config, dict(point.values))
        except InputError as error:
            raise InputError(f"calibration: {point.name}: {error}") from None
        if point.kind != "level" or settings != own:  # else it is the defaults again
            found.append(point)
    return found


def _candidates(given: Any) -> list[dict[str, Any]]:
    if not isinstance(given, list) or not all(isinstance(one, dict) and one for one in given):
        raise refuse("calibration.candidates", given, "a list of mappings of settings, [{swarm.speed: 4}]")
    return given


def calibrate(cells: Sequence[Split]) -> None:
    """Estimate every point in these cells, and note each as soon as it is there."""
    from slcs2_jax.results import Progress
    from slcs2_jax.study.calibration import Notebook
    from slcs2_jax.study.experiment import settings_with

    notebook = Notebook(_folder(cells[0]))
    going = list(_missing(notebook, cells))
    if not going:
        return
    from slcs2_jax import runtime

    runtime.configure(settings_with(cells[0][0], {}).compute)
    with Progress(len(going), label="point") as report:
        for number, (point, lacking) in enumerate(going):
            report.note(f"{number + 1}/{len(going)}: {point.name}")
            runs = [settings_with(config, dict(point.values)) for config, _ in lacking]
            for split, settings, estimate in zip(lacking, runs, _estimates(runs, lacking[0][1]), strict=True):
                notebook.add(_cell(settings), point, estimate, _sizes(split))


def conclude(root: str, cells: Sequence[Split]) -> None:
    """Write the table and the figure of all that has been estimated."""
    from slcs2_jax.results.files import write_text
    from slcs2_jax.study.calibration import Notebook, fits, fits_table

    notebook = Notebook(_folder(cells[0]))
    known = {_cell_of(split): notebook.read(_cell_of(split), _sizes(split)) for split in cells}
    config, own = cells[0]
    found = fits(tried(config, own["calibration"]), known)
    table = fits_table(found)
    place = Path(root) / FOLDER
    write_text(place / "calibration.csv", table.csv())
    write_text(place / "calibration.md", "# Calibration study\n\n" + table.markdown())
    try:
        from slcs2_jax.looking import drawing
        from slcs2_jax.study import figure
    except ImportError:
        print("no figure: it needs matplotlib, the extra plot")
    else:
        drawing.save(lambda: figure.calibration_figure(found), place / "calibration")
    for fit in sorted(found, key=lambda fit: float("inf") if fit.misfit is None else fit.misfit)[:5]:
        print(f"misfit {fit.misfit:.3f}  {fit.point.kind:7}  {fit.point.name}")
    print(f"table {terminal(str(place / 'calibration.md'))}", flush=True)


def _missing(notebook: Any, cells: Sequence[Split]) -> list[tuple[Point, list[Split]]]:
    """Points with the cells that lack them."""
    known = [(split, notebook.read(_cell_of(split), _sizes(split))) for split in cells]
    config, own = cells[0]
    found = []
    for point in tried(config, own["calibration"]):
        lacking = [split for split, values in known if point.values not in values]
        if lacking:
            found.append((point, lacking))
    return found


def _estimates(runs: Sequence[Settings], own: Mapping[str, Any]) -> list[Estimate]:
    from slcs2_jax.policy.decision_list import load_decision_list
    from slcs2_jax.running import driver
    from slcs2_jax.study.calibration import Estimate

    count = own["calibration"]["deployments"]
    designed = driver.deploy_in_runs(runs, load_decision_list(BEHAVIOUR), deployments=count)
    short = [
        dataclasses.replace(one, run_dir=None, search=dataclasses.replace(one.search, fresh_deployments=1))
        for one in runs  # nobody looks at the winner's fresh deployments
    ]
    evolved = driver.evolve(short)
    return [
        Estimate(
            designed=_mean([one.fitness for instance in own for one in instance]),
            evolved=_mean([one.best_fitness for one in summary.instances]),
        )
        for own, summary in zip(designed, evolved, strict=True)
    ]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def _sizes(split: Split) -> dict[str, Any]:
    """What an estimate depends on beside its point: everything but where it is computed and kept."""
    from slcs2_jax.results.documents import checksum

    config, own = split
    kept = {key: value for key, value in config.items() if key not in ("compute", "checkpoint")}
    sizes = {key: config[key] for key in ("seed", "instances", "generations")}
    return sizes | {"deployments": own["calibration"]["deployments"], "settings": checksum(kept)}


def _cell_of(split: Split) -> Cell:
    from slcs2_jax.study.experiment import settings_with

    return _cell(settings_with(split[0], {}))


def _cell(settings: Settings) -> Cell:
    from slcs2_jax.study.arm import cell_of

    return cell_of(settings)


def _folder(split: Split) -> Path:
    return Path(str(split[1]["run_dir"])) / FOLDER
