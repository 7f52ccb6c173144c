"""Best fitness so far, evolution beside random search: python scripts/plot_curves.py OUT.png NAME RUN RANDOM [...].

NAME titles a panel, RUN is the folder of evolution in one world, a run or several, and RANDOM that of
scripts/random_search.py for it. Curves are means over the instances; bands are 90 % confidence intervals of the mean
(Student's t). The figures are printed as a Markdown table.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError
from slcs2_jax.results import FinishedRun, read_run
from slcs2_jax.results.sweep import runs_below

COLOURS = {"evolution": "#0072b2", "random search": "#d55e00"}
MOST_COLUMNS = 4


def runs_of(folder: str) -> list[FinishedRun]:
    """All runs in a folder, and below it."""
    found = [read_run(str(one.run_dir)) for one in runs_below(folder)[0]]
    if not found:
        raise InputError(f"run={folder}: holds no evolution; accepted is the folder of a run or of several")
    return found


def rows_of(runs: Sequence[FinishedRun]) -> dict[tuple[str, int], list[dict]]:
    """The rows of each instance of each run, in the order of its generations."""
    found: dict[tuple[str, int], list[dict]] = {}
    for run in runs:
        for row in sorted(run.rows, key=lambda row: row["generation"]):
            found.setdefault((str(run.path), row["instance"]), []).append(row)
    return found


def curves(runs: Sequence[FinishedRun]) -> NDArray[np.float64]:
    """Best so far after each evaluation: [instances, evaluations], up to the evaluations that every instance made.

    A solution counts from its last deployment on; until the first one is through, its fitness stands for it.
    """
    rows = rows_of(runs)
    if len(rows) < 2:
        raise InputError(f"{runs[0].path}: rows of {len(rows)} instance(s); at least two are required for an interval")
    steps = []
    for own in rows.values():
        best = [row["best"] for row in own]
        deployments = [row["deployments"] for row in own]
        steps.append(np.repeat([best[0], *best], [deployments[0] - 1, *deployments[1:], 1]))
    shortest = min(map(len, steps))
    return np.array([one[:shortest] for one in steps])


def half_width(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Half the 90 % confidence interval of the mean along the first axis."""
    from scipy.stats import t

    count = len(values)
    return t.ppf(0.95, count - 1) * values.std(axis=0, ddof=1) / np.sqrt(count)


def table_row(name: str, search: str, runs: Sequence[FinishedRun]) -> str:
    """One line of the Markdown table; of unfinished runs, what their rows say."""
    rows = rows_of(runs)
    best = [own[-1]["best"] for own in rows.values()]
    spent = sum(row["deployments"] for own in rows.values() for row in own) / len(rows)
    ended = [one["fresh_mean"] for run in runs if run.summary is not None for one in run.summary["instances"]]
    fresh = figure(ended) if len(ended) == len(rows) else "not finished"
    return f"| {name} | {search} | {len(rows)} | {spent:,.0f} | {figure(best)} | {fresh} |"


def figure(values: list[float]) -> str:
    """Mean over the instances and half its 90 % confidence interval."""
    return f"{np.mean(values):.3f} ± {half_width(np.array(values)):.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", help="picture to write")
    parser.add_argument("panels", nargs="+", metavar="NAME RUN RANDOM", help="a panel's title and its two run folders")
    arguments = parser.parse_args()
    if len(arguments.panels) % 3:
        parser.error("panels come as NAME RUN RANDOM")
    panels = [arguments.panels[place : place + 3] for place in range(0, len(arguments.panels), 3)]

    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    columns = min(len(panels), MOST_COLUMNS)
    rows = -(-len(panels) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4 * columns, 3 * rows), sharey=True, squeeze=False)
    lines = ["| world | search | instances | evaluations | best fitness | winner, fresh |", "|---|---|---|---|---|---|"]
    for axis in axes.flat[len(panels) :]:
        axis.remove()
    for axis, (name, *folders) in zip(axes.flat, panels, strict=False):
        for (search, colour), folder in zip(COLOURS.items(), folders, strict=True):
            runs = runs_of(folder)
            best = curves(runs)
            evaluations, mean, half = np.arange(1, best.shape[1] + 1), best.mean(axis=0), half_width(best)
            axis.plot(evaluations, mean, color=colour, label=search)
            axis.fill_between(evaluations, mean - half, mean + half, color=colour, alpha=0.2, linewidth=0)
            lines.append(table_row(name, search, runs))
        axis.set(title=name)
        axis.grid(alpha=0.3)
    figure.supxlabel("evaluations (episodes) per instance", fontsize="medium")
    figure.supylabel("best fitness so far", fontsize="medium")
    axes[0, 0].legend(loc="lower right")
    figure.tight_layout()
    figure.savefig(arguments.out, dpi=150)
    print("\n".join(lines))


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"plot_curves: error: {error}")
