"""The calibration study: how far results move with each assumed value, and how well they fit the paper's figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from slcs2_jax.config import InputError
from slcs2_jax.config.door import present
from slcs2_jax.config.field import refuse
from slcs2_jax.config.model import ENVIRONMENTS
from slcs2_jax.config.schema import accepted_paths, settings_fields, unknown_setting
from slcs2_jax.results.arm import CELLS, OVERALL, PLAIN, Cell
from slcs2_jax.results.files import make_folder
from slcs2_jax.results.rows import append_rows, drop_torn_end, read_rows
from slcs2_jax.study.paper import printed_mean, tuning_means
from slcs2_jax.study.table import Table

Values = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Point:
    """Settings that are tried together; none for the defaults.

    `kind` is default, level (one setting elsewhere), candidate (asked for as it stands) or joint (of the joint search).
    """

    kind: str
    values: Values

    @property
    def name(self) -> str:
        """As a person reads it."""
        return ", ".join(f"{setting}={value:g}" for setting, value in self.values) or "defaults"


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a point comes to in one cell.

    Attributes:
        designed: mean fitness of the designed behaviour's deployments.
        evolved: mean over the instances of the best fitness of a short evolution.
    """

    designed: float
    evolved: float


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A point's estimates in all its cells and how far they are from the paper's.

    Attributes:
        misfit: root mean square of all differences from the paper's figures, in fitness; None without any.
        misfit_designed, misfit_evolved: of the designed behaviour's table alone, and of the evolved figures alone.
    """

    point: Point
    estimates: Mapping[Cell, Estimate]
    misfit: float | None
    misfit_designed: float | None
    misfit_evolved: float | None


def points(
    levels: Mapping[str, Sequence[float]],
    joint: Mapping[str, Sequence[float]],
    samples: int,
    candidates: Sequence[Mapping[str, float]] = (),
) -> list[Point]:
    """The defaults, every level of every setting alone, the candidates, and a Sobol sequence between the joint
    settings' bounds.

    Raises:
        InputError: no such setting, not two bounds, or samples that are neither 0 nor a power of two.
    """
    for name in (*levels, *joint, *(name for candidate in candidates for name in candidate)):
        if name not in accepted_paths():
            raise unknown_setting(name)
    found = [Point("default", ())]
    found += [Point("level", ((name, value),)) for name, values in levels.items() for value in values]
    found += [Point("candidate", tuple(candidate.items())) for candidate in candidates]
    return found + (_joint(joint, samples) if samples and joint else [])


def _joint(joint: Mapping[str, Sequence[float]], samples: int) -> list[Point]:
    if samples < 0 or samples & (samples - 1):
        raise refuse("calibration.samples", samples, "0 or a power of two")
    for name, bounds in joint.items():
        if len(bounds) != 2 or not bounds[0] < bounds[1]:
            raise refuse(f"calibration.joint.{name}", list(bounds), "a lower and an upper bound")
    whole = {field.name for _, field in settings_fields() if field.kind is int}
    low, high = np.array(list(joint.values()), dtype=np.float64).T
    draws = qmc.scale(qmc.Sobol(len(joint), rng=np.random.default_rng(0)).random(samples), low, high)
    return [
        Point("joint", tuple((name, _rounded(value, name in whole)) for name, value in zip(joint, draw, strict=True)))
        for draw in draws
    ]


def _rounded(value: float, whole: bool) -> float:
    """A value that can be typed: four digits, or a whole number."""
    return round(value) if whole else float(f"{value:.4g}")


class Notebook:
    """What has been estimated, a file for each cell, so that a study that is repeated adds only what is missing."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def read(self, cell: Cell, sizes: Mapping[str, Any]) -> dict[Values, Estimate]:
        """The estimates of a cell made with these sizes and settings. Raises InputError for a damaged file."""
        file = self._file(cell)
        found: dict[Values, Estimate] = {}
        try:
            for row in read_rows(file) if present(file) else ():
                if row["sizes"] == dict(sizes):
                    values = tuple((str(name), value) for name, value in row["values"])
                    found[values] = Estimate(designed=float(row["designed"]), evolved=float(row["evolved"]))
        except (InputError, ValueError, KeyError, TypeError) as error:
            raise InputError(f"{file}: {error}; delete that line") from None
        return found

    def add(self, cell: Cell, point: Point, estimate: Estimate, sizes: Mapping[str, Any]) -> None:
        """Note an estimate. Raises StorageError."""
        row = {"values": point.values, "designed": estimate.designed, "evolved": estimate.evolved, "sizes": dict(sizes)}
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        make_folder(self.folder, inside=self.folder.parent)
        drop_torn_end(self._file(cell))
        append_rows(self._file(cell), [row])

    def _file(self, cell: Cell) -> Path:
        return self.folder / f"{cell.name}.jsonl"


def fits(tried: Iterable[Point], estimates: Mapping[Cell, Mapping[Values, Estimate]]) -> list[Fit]:
    """How well each point fits, of those that every cell has."""
    found = []
    for point in tried:
        if estimates and all(point.values in own for own in estimates.values()):
            own = {cell: estimates[cell][point.values] for cell in CELLS if cell in estimates}
            designed, evolved = _differences(own)
            found.append(
                Fit(
                    point=point,
                    estimates=own,
                    misfit=_rms(designed + evolved),
                    misfit_designed=_rms(designed),
                    misfit_evolved=_rms(evolved),
                )
            )
    return found


def _differences(own: Mapping[Cell, Estimate]) -> tuple[list[float], list[float]]:
    """Ours less the paper's: the designed table, and the means of evolved behaviours that the paper prints."""
    table = tuning_means()
    designed = [one.designed - table[cell.name] for cell, one in own.items()]
    evolved = []
    for cell, one in own.items():
        printed = printed_mean("contributions", PLAIN, cell.name)
        if printed is not None:
            evolved.append(one.evolved - printed)
    for name in ("short", "long"):
        cells = [Cell(environment, name) for environment in ENVIRONMENTS]
        printed = printed_mean("designed", PLAIN, f"{OVERALL}_{name}")
        if printed is not None and all(cell in own for cell in cells):
            evolved.append(sum(own[cell].evolved for cell in cells) / len(cells) - printed)
    return designed, evolved


def _rms(values: Sequence[float]) -> float | None:
    return math.sqrt(sum(value**2 for value in values) / len(values)) if values else None


def fits_table(found: Sequence[Fit]) -> Table:
    """Every point: the defaults, the levels, the candidates, then the joint search from the best fit on."""
    cells = [cell for cell in CELLS if found and cell in found[0].estimates]
    header: tuple[str, ...] = (
        "tried",
        "settings",
        "misfit",
        "misfit designed",
        "misfit evolved",
        "mean designed",
        "mean evolved",
    )
    header += tuple(f"{kind} {cell.title}" for kind in ("designed", "evolved") for cell in cells)
    order = ["default", "level", "candidate", "joint"]

    def place(fit: Fit) -> tuple[int, float]:
        joint = fit.point.kind == "joint" and fit.misfit is not None
        return order.index(fit.point.kind), fit.misfit if joint and fit.misfit is not None else 0.0

    rows = []
    for fit in sorted(found, key=place):
        designed = [fit.estimates[cell].designed for cell in cells]
        evolved = [fit.estimates[cell].evolved for cell in cells]
        rows.append((
            fit.point.kind, fit.point.name, fit.misfit, fit.misfit_designed, fit.misfit_evolved,
            sum(designed) / len(cells), sum(evolved) / len(cells), *designed, *evolved,
        ))  # fmt: skip
    return Table("Calibration: fitness and its distance from the paper's figures", header, tuple(rows))
