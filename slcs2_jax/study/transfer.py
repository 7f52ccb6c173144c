"""What winners are worth where they did not evolve: a matrix of means, and each row against what it must beat.

Rows are sources: what evolved in one kind of world, with its inherited quality or without, generalists, behaviours.
W = worlds of a kind; a source's figure in a world is the mean over its winners.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from slcs2_jax.config.worlds import Kind
from slcs2_jax.study.statistics import Comparison, Values, compare, holm_of, mean_interval, permuted
from slcs2_jax.study.table import Row, Table

ALL = "all"
SPECIALIST, GENERALIST, BEHAVIOUR = "specialist", "generalist", "behaviour"


@dataclass(frozen=True, eq=False)
class Source:
    """A row of the matrix.

    Attributes:
        name: as a person reads it.
        role: specialist, generalist or behaviour.
        home: the kind of world that a specialist evolved in.
        quality: kept or forgotten; "" where nothing was inherited.
        fitness: by kind of world, float64[winners, W].
    """

    name: str
    role: str
    home: str
    quality: str
    fitness: Mapping[str, Values]

    @property
    def title(self) -> str:
        """With what became of its quality."""
        return f"{self.name}, quality {self.quality}" if self.quality else self.name

    def by_world(self, kind: str) -> Values:
        """float64[W]: mean over winners; of `all`, the worlds of all kinds."""
        if kind == ALL:
            return np.concatenate([values.mean(axis=0) for values in self.fitness.values()])
        return self.fitness[kind].mean(axis=0)

    @property
    def winners(self) -> int:
        """How many it has."""
        return len(next(iter(self.fitness.values())))


def columns(sources: Sequence[Source]) -> list[str]:
    """Kinds of worlds, then all of them together."""
    return [*sources[0].fitness, ALL]


def matrix_table(sources: Sequence[Source]) -> Table:
    """The mean of every source in every kind of world."""
    names = columns(sources)
    rows: list[Row] = [
        (one.name, one.role, one.quality or None, one.winners, *(float(one.by_world(kind).mean()) for kind in names))
        for one in sources
    ]
    header = ("evolved in", "what", "inherited quality", "winners", *names)
    return Table("Mean fitness in worlds that were not seen", header, tuple(rows))


def contests_table(sources: Sequence[Source]) -> Table:
    """Every source in every kind of world, with its interval over worlds; against the first behaviour, and against the
    best specialist from elsewhere: pair by pair over worlds, with Holm's correction within a kind."""
    rows: list[Row] = []
    behaviour = next((one for one in sources if one.role == BEHAVIOUR), None)
    for kind in columns(sources):
        rivals = [(one, behaviour, best_elsewhere(sources, kind, one)) for one in sources]
        against = [_contests([(one, pair[place]) for one, *pair in rivals], kind) for place in (0, 1)]
        for (one, _, other), first, second in zip(rivals, *against, strict=True):
            values = one.by_world(kind)
            rows.append((
                kind, one.name, one.role, one.quality or None, len(values), float(values.mean()),
                mean_interval(values), *first, None if other is None else other.title, *second,
            ))  # fmt: skip
    header = (
        "worlds", "evolved in", "what", "inherited quality", "n", "mean", "CI90",
        "less designed", "BCa 90, designed", "permutation p, designed", "Holm p, designed", "Wilcoxon p, designed",
        "best specialist from elsewhere", "less that", "BCa 90, specialist", "permutation p, specialist",
        "Holm p, specialist", "Wilcoxon p, specialist",
    )  # fmt: skip
    return Table("Against the designed behaviour and the best specialist from elsewhere", header, tuple(rows))


def best_elsewhere(sources: Sequence[Source], kind: str, other: Source) -> Source | None:
    """The specialist, none of the source's own name, that is best in a kind of world in which it did not evolve."""
    from_elsewhere = [one for one in sources if one.role == SPECIALIST and one.home != kind and one.name != other.name]
    return max(from_elsewhere, key=lambda one: float(one.by_world(kind).mean()), default=None)


def _contests(pairs: Sequence[tuple[Source, Source | None]], kind: str) -> list[Row]:
    """For each pair: mean difference and its interval, p of the permutation test, the same corrected, Wilcoxon's p;
    None for a source without a rival."""
    found: list[Comparison | None] = []
    means: list[float | None] = []
    for one, rival in pairs:
        both = None if rival is None or rival is one else (one.by_world(kind), rival.by_world(kind))
        found.append(None if both is None else compare(*both))
        means.append(None if both is None else permuted(*both))
    return [
        (None,) * 5 if one is None else (one.difference, one.bootstrap, p, corrected, one.p_wilcoxon)
        for one, p, corrected in zip(found, means, holm_of(means), strict=True)
    ]


def names_of(kinds: Sequence[Kind]) -> list[str]:
    """Kinds as columns are called; entries of one kind belong together."""
    return list(dict.fromkeys(kind.name for kind in kinds))
