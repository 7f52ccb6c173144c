"""The tables of a sweep: what differs, responses to one setting, means over two, and their interactions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from slcs2_jax.config.field import show
from slcs2_jax.results.arm import arm_title
from slcs2_jax.study.collect import Outcome
from slcs2_jax.study.factor import Factor, shared_changes, values_of
from slcs2_jax.study.response import Grid, grids, responses
from slcs2_jax.study.study import METRICS, Study
from slcs2_jax.study.table import Row, Table


def differences_table(outcomes: Sequence[Outcome], factors: Sequence[Factor]) -> Table:
    """In which settings the runs differ: every value with the number of instances that have it."""
    held = [values_of(one.settings, factors) for one in outcomes]
    rows: list[Row] = []
    for factor in factors:
        counts = Counter(own[factor.name] for own in held)
        values = ", ".join(f"{counts[value]} at {show(value)}" for value in factor.values)
        bases = sorted({show(value) for value in factor.base.values()})
        rows.append((factor.name, values, factor.unit or None, ", ".join(bases), show(factor.default), factor.help))
    return Table(
        "Settings that differ, and the instances with each value",
        ("setting", "instances", "unit", "compared with", "default", "meaning"),
        tuple(rows),
    )


def shared_table(outcomes: Sequence[Outcome]) -> Table:
    """What all runs have alike and not at its default."""
    changes = shared_changes([one.settings for one in outcomes])
    rows = tuple((name, show(value), show(default)) for name, value, default in changes)
    return Table("The same in all runs, and not at its default", ("setting", "value", "default"), rows)


def responses_table(study: Study, metric: str) -> Table:
    """A row for each value of each factor, with its effect against the base."""
    header = (
        "world", "algorithm", "setting", "value", "base", "n", "mean", "SD", "CI90", "BCa 90", "> -1", "> 0",
        "less the base", "BCa 90 of that", "Mann-Whitney p", "Holm p", "A12", "A12 CI90",
    )  # fmt: skip
    rows: list[Row] = []
    for one in responses(study, metric):
        for level in one.levels:
            told, effect = level.description, level.effect
            beside: Row = (None,) * 6
            if effect is not None:
                beside = (
                    effect.difference, effect.bootstrap, effect.p_mann_whitney, effect.p_holm, effect.a12,
                    effect.a12_interval,
                )  # fmt: skip
            rows.append((
                one.place.title, arm_title(one.algorithm), one.factor.name, show(level.value),
                "base" if level.value == one.base else "", told.count,
                told.mean, told.sd, told.interval, told.bootstrap, told.delivering, told.successful, *beside,
            ))  # fmt: skip
    return Table(f"{study.title}: response to each setting alone, {METRICS[metric]}", header, tuple(rows))


def grid_table(grid: Grid) -> Table:
    """Means by the values of two factors: a row for each of the first's, a column for each of the second's."""
    columns = [value for value in grid.columns.values if any(pair[1] == value for pair in grid.means)]
    rows: list[Row] = []
    for value in grid.rows.values:
        means: list[Any] = [grid.means.get((value, column)) for column in columns]
        if any(mean is not None for mean in means):
            rows.append((show(value), *means))
    title = (
        f"{arm_title(grid.algorithm)}, {grid.place.title}: {METRICS[grid.metric]}, mean of {grid.count} instances by "
        f"{grid.rows.name} (rows) and {grid.columns.name} (columns)"
    )
    return Table(title, (grid.rows.name, *(f"{grid.columns.name}={show(value)}" for value in columns)), tuple(rows))


def interactions_table(study: Study, metric: str) -> Table:
    """What changes of two settings do together beyond the sum of their effects alone."""
    rows: list[Row] = []
    for grid in grids(study, metric):
        for one in grid.interactions:
            rows.append((
                grid.place.title, arm_title(grid.algorithm), f"{grid.rows.name}={show(one.row)}",
                f"{grid.columns.name}={show(one.column)}", grid.count, one.value, one.interval,
            ))  # fmt: skip
    return Table(
        f"{study.title}: interactions, {METRICS[metric]}",
        ("world", "algorithm", "change", "with", "n", "beyond the sum", "BCa 90"),
        tuple(rows),
    )


def grids_table(study: Study, metric: str) -> Table:
    """All means over two settings as tidy data, a row for each combination."""
    rows = tuple(
        (grid.place.title, arm_title(grid.algorithm), grid.rows.name, show(row), grid.columns.name, show(column),
         grid.count, mean)
        for grid in grids(study, metric)
        for (row, column), mean in grid.means.items()
    )  # fmt: skip
    header = ("world", "algorithm", "setting", "value", "second setting", "second value", "n", "mean")
    return Table(f"{study.title}: means over two settings, {METRICS[metric]}", header, rows)
