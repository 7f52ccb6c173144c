"""Figures in the manner of the paper's: fitness with its CI90 in every world, and best so far by what was spent.

Told apart in grey too: by marker, by line style and by how dark the colours are. The same results give the same bytes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from slcs2_jax.config.model import RANGES
from slcs2_jax.results.arm import CELLS, PLACES, Cell, arm_title
from slcs2_jax.study.calibration import Fit
from slcs2_jax.study.paper import printed_mean
from slcs2_jax.study.statistics import mean_interval
from slcs2_jax.study.study import BEST, GENERATION, METRICS, Study

# colour, marker, line; from dark to light
STYLES = (
    ("#000000", "o", "-"),
    ("#d55e00", "s", "--"),
    ("#56b4e9", "^", "-."),
    ("#b8b800", "D", ":"),
    ("#999999", "v", (0, (1, 1))),
    ("#cc79a7", "P", (0, (5, 1, 1, 1, 1, 1))),
)


def fitness_figure(study: Study, metric: str) -> Figure:
    """Mean and CI90 of every arm in every world, a panel for each range; crosses are what the paper prints."""
    described = study.descriptions(metric)
    ranges = [name for name in RANGES if any(place.range == name for _, place in described)]
    figure = Figure(figsize=(7.0, 0.6 + 2.4 * len(ranges)), layout="constrained")
    panels = figure.subplots(len(ranges), 1, squeeze=False, sharey=True)[:, 0]
    for panel, name in zip(panels, ranges, strict=True):
        places = [place for place in PLACES if place.range == name]
        for number, arm in enumerate(study.arms):
            _draw_arm(panel, study, metric, arm, number, places)
        panel.set_xticks(range(len(places)), [place.environment.replace("_", " ") for place in places])
        panel.set_xlim(-0.5, len(places) - 0.5)
        panel.set_ylabel("fitness")
        panel.set_title(f"{name} range", loc="left")
        panel.axhline(0, color="#cccccc", linewidth=0.6, zorder=0)
    legend(figure, panels)
    figure.supxlabel(f"{METRICS[metric]}, mean and 90 % confidence interval")
    return figure


def _draw_arm(panel: Any, study: Study, metric: str, arm: str, number: int, places: list[Cell]) -> None:
    colour, marker, _ = STYLES[number % len(STYLES)]
    described = study.descriptions(metric)
    width = 0.8 / len(study.arms)
    for at, place in enumerate(places):
        x = at + (number - (len(study.arms) - 1) / 2) * width
        printed = printed_mean(study.name, arm, place.name)
        if printed is not None:
            panel.plot(x, printed, "x", color="#555555", markersize=7, label="printed in the paper", zorder=1)
        one = described.get((arm, place))
        if one is None:
            continue
        panel.plot(x, one.mean, marker, color=colour, markersize=4, linestyle="none", label=arm_title(arm))
        if one.interval is not None:
            panel.vlines(x, *one.interval, color=colour, linewidth=1)
            panel.hlines(one.interval, x - width / 6, x + width / 6, color=colour, linewidth=1)
        beside = {"xytext": (3, 2), "textcoords": "offset points", "fontsize": 5.5}
        panel.annotate(f"{one.mean:.2f}", (x, one.mean), **beside)


def curves_figure(study: Study, by: str = GENERATION) -> Figure:
    """Best fitness so far in every cell, by one of `SPENT`: mean over the instances and its CI90."""
    cells = [cell for cell in CELLS if study.seeds(cell, BEST)]
    ranges = [name for name in RANGES if any(cell.range == name for cell in cells)]
    columns = max(sum(cell.range == name for cell in cells) for name in ranges)
    figure = Figure(figsize=(1.0 + 2.0 * columns, 0.7 + 1.8 * len(ranges)), layout="constrained")
    panels = figure.subplots(len(ranges), columns, squeeze=False, sharex=by == GENERATION, sharey=True)
    for panel in panels.flat:
        panel.set_axis_off()
    for row, name in enumerate(ranges):
        for column, cell in enumerate(cell for cell in cells if cell.range == name):
            panel = panels[row, column]
            panel.set_axis_on()
            panel.set_title(f"{cell.title} (n = {len(study.seeds(cell, BEST))})")
            _draw_curves(panel, study, cell, by)
    legend(figure, panels.flat)
    figure.supxlabel(by)
    lines = [f"{METRICS[BEST]} so far,", "mean and CI90"]
    figure.supylabel((" " if len(ranges) > 1 else "\n").join(lines))  # one row of panels is lower than the text is long
    return figure


def _draw_curves(panel: Any, study: Study, cell: Cell, by: str) -> None:
    looks = study.looks(cell, by)
    for number, arm in enumerate(study.arms):
        colour, _, line = STYLES[number % len(STYLES)]
        curves = study.curves(arm, cell, by)
        if not len(curves):  # of a sweep: it has nothing in this world
            continue
        panel.plot(looks, curves.mean(axis=0), color=colour, linestyle=line, linewidth=1.2, label=arm_title(arm))
        if len(curves) > 1:
            bands = [mean_interval(column) for column in curves.T]
            low, high = np.array(bands, dtype=np.float64).T
            panel.fill_between(looks, low, high, color=colour, alpha=0.15, linewidth=0)


def calibration_figure(fits: Sequence[Fit]) -> Figure:
    """How far each level of each setting, alone, takes the misfit and the means from those of the defaults; below
    them, without labels, the points of the joint search."""
    rows: dict[str, list[tuple[str, Fit]]] = {}
    for fit in fits:
        if fit.point.kind == "level":
            [(setting, value)] = fit.point.values
            rows.setdefault(setting, []).append((f"{value:g}", fit))
    joint = [("", fit) for fit in fits if fit.point.kind == "joint"]
    if joint:
        rows["joint search"] = joint
    default = next((fit for fit in fits if fit.point.kind == "default"), None)
    figure = Figure(figsize=(7.5, 1.2 + 0.28 * len(rows)), layout="constrained")
    panels = figure.subplots(1, len(_MEASURES), sharey=True)
    colour, marker, _ = STYLES[0]
    for panel, (title, measure) in zip(panels, _MEASURES, strict=True):
        if default is not None:
            panel.axvline(measure(default), color="#999999", linewidth=0.8, label="defaults")
        every = [measure(fit) for own in rows.values() for _, fit in own]
        for row, own in enumerate(rows.values()):
            places = [(measure(fit), name) for name, fit in own]
            panel.plot([x for x, _ in places], [row] * len(places), marker, color=colour, markersize=3)
            for x, text in _apart(places, least=_LABEL_ROOM * (max(every) - min(every))):
                panel.annotate(text, (x, row), xytext=(0, 3), textcoords="offset points", fontsize=5, ha="center")
        panel.set_xlabel(title)
        panel.grid(axis="y", color="#dddddd", linewidth=0.5)
    panels[0].set_yticks(range(len(rows)), list(rows))
    panels[0].set_ylim(len(rows) - 0.5, -0.7)
    legend(figure, panels[:1])
    return figure


def _apart(places: Sequence[tuple[float, str]], *, least: float) -> list[tuple[float, str]]:
    """Labels by place from left to right; those nearer to the one before than `least` become one with it."""
    groups: list[list[tuple[float, str]]] = []
    for place in sorted((x, name) for x, name in places if name and not math.isnan(x)):
        if groups and place[0] - groups[-1][-1][0] < least:
            groups[-1].append(place)
        else:
            groups.append([place])
    return [(_mean(x for x, _ in group), ", ".join(name for _, name in group)) for group in groups]


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


_LABEL_ROOM = 0.08  # of a panel's width, for a label of two or three digits
_MEASURES: tuple[tuple[str, Callable[[Fit], float]], ...] = (
    ("misfit (fitness, RMS)", lambda fit: math.nan if fit.misfit is None else fit.misfit),
    ("designed, mean fitness", lambda fit: _mean(one.designed for one in fit.estimates.values())),
    ("short evolution, mean fitness", lambda fit: _mean(one.evolved for one in fit.estimates.values())),
)


def legend(figure: Figure, panels: Iterable[Any]) -> None:
    """One legend for all panels, above them."""
    unique: dict[str, Any] = {}
    for panel in panels:
        handles, labels = panel.get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True)) | unique
    figure.legend(unique.values(), unique.keys(), loc="outside upper center", ncols=4, frameon=False)
