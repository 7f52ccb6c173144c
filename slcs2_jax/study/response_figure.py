"""Figures of a sweep: response curves to one setting, and heat maps over two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from slcs2_jax.config.field import show
from slcs2_jax.results.arm import arm_title
from slcs2_jax.study.figure import STYLES, legend
from slcs2_jax.study.response import Grid, Response
from slcs2_jax.study.study import METRICS

_COLUMNS = 4  # panels side by side


def responses_figure(found: Sequence[Response]) -> Figure:
    """The responses to one factor by one metric: a panel for each world, a line for each algorithm, with CI90s."""
    factor, metric = found[0].factor, found[0].metric
    places = list(dict.fromkeys(one.place for one in found))
    algorithms = list(dict.fromkeys(one.algorithm for one in found))
    figure, panels = _panels(len(places))
    for panel, place in zip(panels, places, strict=False):
        for one in found:
            if one.place == place:
                _draw_response(panel, one, algorithms.index(one.algorithm))
        panel.set_title(place.title)
        if not factor.numeric:
            panel.set_xticks(range(len(factor.values)), [show(value) for value in factor.values])
    legend(figure, panels)
    figure.supxlabel(factor.label)
    figure.supylabel(f"{METRICS[metric]},\nmean and 90 % confidence interval")
    return figure


def _draw_response(panel: Any, one: Response, number: int) -> None:
    colour, marker, line = STYLES[number % len(STYLES)]
    factor = one.factor
    x = [float(level.value if factor.numeric else factor.values.index(level.value)) for level in one.levels]
    told = [level.description for level in one.levels]
    means = np.array([each.mean for each in told])
    panel.plot(
        x, means, marker=marker, linestyle=line, color=colour, markersize=4, linewidth=1.2,
        label=arm_title(one.algorithm),
    )  # fmt: skip
    for at, each in zip(x, told, strict=True):
        if each.interval is not None:
            panel.vlines(at, *each.interval, color=colour, linewidth=1)
        panel.annotate(f"n={each.count}", (at, each.mean), xytext=(3, -8), textcoords="offset points", fontsize=5)


def grids_figure(found: Sequence[Grid]) -> Figure:
    """The means over two factors by one metric: a panel for each algorithm in each world, in one scale of colours."""
    figure, panels = _panels(len(found))
    every = [mean for grid in found for mean in grid.means.values()]
    limits = {"vmin": min(every), "vmax": max(every)}
    image: Any = None
    for panel, grid in zip(panels, found, strict=False):
        values = np.array([[grid.means.get((r, c), np.nan) for c in grid.columns.values] for r in grid.rows.values])
        image = panel.imshow(values, origin="lower", aspect="auto", cmap="cividis", **limits)
        middle = (limits["vmin"] + limits["vmax"]) / 2
        for (row, column), mean in np.ndenumerate(values):
            if np.isfinite(mean):
                ink = "white" if mean < middle else "black"
                panel.text(column, row, f"{mean:.2f}", ha="center", va="center", color=ink, fontsize=6)
        panel.set_xticks(range(len(grid.columns.values)), [show(value) for value in grid.columns.values])
        panel.set_yticks(range(len(grid.rows.values)), [show(value) for value in grid.rows.values])
        panel.set_title(f"{arm_title(grid.algorithm)}, {grid.place.title} (n = {grid.count})")
    figure.colorbar(image, ax=list(panels[: len(found)]), label=f"mean of {METRICS[found[0].metric]}")
    figure.supxlabel(found[0].columns.label)
    figure.supylabel(found[0].rows.label)
    return figure


def _panels(count: int) -> tuple[Figure, list[Any]]:
    """A figure with so many panels, those left over empty."""
    columns = min(count, _COLUMNS)
    rows = -(-count // columns)
    figure = Figure(figsize=(1.2 + 2.4 * columns, 0.9 + 2.2 * rows), layout="constrained")
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for panel in panels[count:]:
        panel.set_axis_off()
    return figure, panels
