"""One test for each arm over many worlds at once: every instance is a pair, of the reference and of the arm.

Pairs share their world and the seed of their search, so what a world is worth cancels out. Wilcoxon's signed-rank test
and the permutation test of the mean difference, each with Holm's correction over the arms of a table's part: all
worlds, short and long ones.
"""

from __future__ import annotations

import numpy as np

from slcs2_jax.config.model import RANGES
from slcs2_jax.results.arm import CELLS, Cell, arm_title
from slcs2_jax.study.statistics import Comparison, Values, compare, holm_of, permuted
from slcs2_jax.study.study import METRICS, Study
from slcs2_jax.study.table import Row, Table


def pairs(study: Study, arm: str, cells: tuple[Cell, ...], metric: str) -> tuple[Values, Values]:
    """Figures of the reference and of an arm in all instances in these cells that both have."""
    found: list[tuple[float, float]] = []
    for cell in cells:
        mine, its = study.figures(study.reference, cell, metric), study.figures(arm, cell, metric)
        found += [(mine[seed], its[seed]) for seed in sorted(mine.keys() & its.keys())]
    both = np.array(found, dtype=np.float64).reshape(-1, 2)
    return both[:, 0], both[:, 1]


def overall(study: Study, cells: tuple[Cell, ...], metric: str) -> list[tuple[str, Comparison, float | None]]:
    """Every arm that shares instances with the reference: its comparison, and its corrected p."""
    found = []
    for arm in study.arms[1:]:
        mine, its = pairs(study, arm, cells, metric)
        if len(mine):
            found.append((arm, compare(mine, its)))
    corrected = holm_of([one.p_wilcoxon for _, one in found])
    return [(arm, one, p) for (arm, one), p in zip(found, corrected, strict=True)]


def overall_table(study: Study, metric: str) -> Table:
    """The reference against every other arm over all worlds, and over those of each range."""
    parts = {"all": CELLS} | {f"all {name}": tuple(cell for cell in CELLS if cell.range == name) for name in RANGES}
    rows: list[Row] = []
    for name, cells in parts.items():
        told = overall(study, cells, metric)
        means = [permuted(*pairs(study, arm, cells, metric)) for arm, _, _ in told]
        for (arm, one, p), mean_p, mean_holm in zip(told, means, holm_of(means), strict=True):
            worlds = sum(bool(len(pairs(study, arm, (cell,), metric)[0])) for cell in cells)
            won = sum(_ahead(study, arm, cell, metric) for cell in cells)
            rows.append((
                name, arm_title(arm), one.count, worlds, won, one.difference, one.bootstrap, mean_p, mean_holm,
                one.p_wilcoxon, p, one.a12,
            ))  # fmt: skip
    header = (
        "worlds", "against", "pairs", "cells", "cells ahead", "difference", "BCa 90", "permutation p",
        "Holm p, permutation", "Wilcoxon p", "Holm p, Wilcoxon", "A12",
    )  # fmt: skip
    title = f"{study.title}: {arm_title(study.reference)} less the other arm, pair by pair, {METRICS[metric]}"
    return Table(title, header, tuple(rows))


def _ahead(study: Study, arm: str, cell: Cell, metric: str) -> bool:
    mine, its = pairs(study, arm, (cell,), metric)
    return bool(len(mine) and mine.mean() >= its.mean())
