"""Does a comparison of algorithms keep its direction under other settings? The same comparison at every point of a
sweep."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from slcs2_jax.results.arm import CELLS, Cell, arm_at, arm_title, ordered
from slcs2_jax.study.factor import point_text
from slcs2_jax.study.statistics import Comparison, compare
from slcs2_jax.study.study import METRICS, Study
from slcs2_jax.study.table import Row, Table


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """The first algorithm against another in a world, on the same instances, with some settings changed.

    Attributes:
        changes: as a user types them; empty at the base.
        comparison: above 0 means that the first algorithm is better.
        base: mean difference with nothing changed; None where that was not run.
    """

    place: Cell
    against: str
    changes: str
    comparison: Comparison
    base: float | None

    @property
    def direction(self) -> str | None:
        """Is the better algorithm the one that it is at the base? None where that was not run."""
        if not self.changes:
            return "base"
        if self.base is None:
            return None
        return "same" if self.comparison.difference * self.base > 0 else "other"


def repeated(study: Study, metric: str) -> Iterator[Repeated]:
    """Every comparison of the first algorithm with another, world by world, the base first; none without another."""
    first, *others = ordered(one.algorithm for one in study.outcomes)
    changed = {one.arm: point_text(one.point) for one in study.outcomes}
    points = dict.fromkeys(changed[arm] for arm in study.arms)  # the base first, then one change, then more
    for place in CELLS:
        for against in others:
            base = None
            for changes in points:
                mine, its = (study.figures(arm_at(arm, changes), place, metric) for arm in (first, against))
                if seeds := sorted(mine.keys() & its.keys()):
                    found = compare(*(np.array([own[seed] for seed in seeds]) for own in (mine, its)))
                    base = found.difference if not changes else base
                    yield Repeated(place=place, against=against, changes=changes, comparison=found, base=base)


def robustness_table(study: Study, metric: str) -> Table:
    """A row for each algorithm, world and combination of settings that was run; empty with one algorithm."""
    rows: list[Row] = [
        (one.place.title, arm_title(one.against), one.changes or "as they are", one.comparison.count,
         one.comparison.difference, one.comparison.bootstrap, one.comparison.p_mann_whitney, one.comparison.a12,
         one.direction)
        for one in repeated(study, metric)
    ]  # fmt: skip
    first = ordered(one.algorithm for one in study.outcomes)[0]
    header = ("world", "against", "settings", "n", "difference", "BCa 90", "Mann-Whitney p", "A12", "direction")
    title = f"{study.title}: {arm_title(first)} less the other algorithm, under each setting, {METRICS[metric]}"
    return Table(title, header, tuple(rows))
