"""How figures respond to the settings of a sweep: to one alone, and to two together."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from slcs2_jax.results.arm import CELLS, Cell, arm_at, ordered
from slcs2_jax.study.factor import Factor, point_text
from slcs2_jax.study.statistics import Comparison, Description, Interval, Values, compare, describe, holm
from slcs2_jax.study.study import Study


@dataclass(frozen=True, kw_only=True)
class Level:
    """One value of a factor.

    Attributes:
        description: of the figures at this value.
        effect: against the base value; above 0 if this value is better. None for the base itself.
    """

    value: Any
    description: Description
    effect: Comparison | None


@dataclass(frozen=True, kw_only=True)
class Response:
    """An algorithm in a world at the values of one factor, the others at their base; on the same instances."""

    algorithm: str
    place: Cell
    factor: Factor
    metric: str
    levels: tuple[Level, ...]

    @property
    def base(self) -> Any:
        """The factor's value that the others are compared with."""
        return self.factor.base[self.place]


@dataclass(frozen=True, kw_only=True)
class Interaction:
    """What two changes together do beyond the sum of what each does alone: mean over instances, and its interval."""

    row: Any
    column: Any
    value: float
    interval: Interval | None


@dataclass(frozen=True, kw_only=True)
class Grid:
    """An algorithm in a world at the values of two factors, the others at their base; on the same instances.

    Attributes:
        count: number of instances.
        means: mean figure by the values of both factors; a combination without results is not in it.
    """

    algorithm: str
    place: Cell
    rows: Factor
    columns: Factor
    metric: str
    count: int
    means: Mapping[tuple[Any, Any], float]
    interactions: tuple[Interaction, ...]


@cache
def responses(study: Study, metric: str) -> tuple[Response, ...]:
    """Every factor's, of every algorithm in every world where it has two values or more.

    Holm's family: all the effects that are returned.
    """
    found = []
    for algorithm, place in _pairs(study):
        for factor in study.factors:
            if place not in factor.base:
                continue
            samples = _shared(
                {value: _figures(study, algorithm, place, metric, {factor: value}) for value in factor.values}
            )
            if len(samples) > 1:
                found.append(_response(algorithm, place, factor, metric, samples))
    return tuple(_corrected(found))


@cache
def grids(study: Study, metric: str) -> tuple[Grid, ...]:
    """Every two factors', of every algorithm in every world where both were changed together."""
    found = []
    for algorithm, place in _pairs(study):
        for rows, columns in itertools.combinations(study.factors, 2):
            if place not in rows.base or place not in columns.base:
                continue
            samples = _shared({
                (row, column): _figures(study, algorithm, place, metric, {rows: row, columns: column})
                for row in rows.values
                for column in columns.values
            })  # fmt: skip
            at = rows.base[place], columns.base[place]
            if any(row != at[0] and column != at[1] for row, column in samples):
                found.append(
                    Grid(
                        algorithm=algorithm,
                        place=place,
                        rows=rows,
                        columns=columns,
                        metric=metric,
                        count=len(next(iter(samples.values()))),
                        means={pair: float(values.mean()) for pair, values in samples.items()},
                        interactions=tuple(_interactions(samples, *at)),
                    )
                )
    return tuple(found)


def _pairs(study: Study) -> Iterator[tuple[str, Cell]]:
    algorithms = ordered(one.algorithm for one in study.outcomes)
    present = {(one.algorithm, one.cell) for one in study.outcomes}
    return ((algorithm, place) for place in CELLS for algorithm in algorithms if (algorithm, place) in present)


def _figures(study: Study, algorithm: str, place: Cell, metric: str, at: Mapping[Factor, Any]) -> dict[int, float]:
    """By seed, with these factors at these values and the others at their base."""
    changes = tuple((one.name, value) for one, value in at.items() if value != one.base[place])
    return study.figures(arm_at(algorithm, point_text(changes)), place, metric)


def _shared(figures: Mapping[Any, Mapping[int, float]]) -> dict[Any, Values]:
    """Of the instances that all have that have any; nothing if there is none."""
    known = {key: own for key, own in figures.items() if own}
    seeds = sorted(set.intersection(*(set(own) for own in known.values()))) if known else []
    return {key: np.array([own[seed] for seed in seeds]) for key, own in known.items()} if seeds else {}


def _response(algorithm: str, place: Cell, factor: Factor, metric: str, samples: Mapping[Any, Values]) -> Response:
    base = samples.get(factor.base[place])
    levels = [
        Level(
            value=value,
            description=describe(sample),
            effect=None if base is None or value == factor.base[place] else compare(sample, base),
        )
        for value, sample in samples.items()
    ]
    return Response(algorithm=algorithm, place=place, factor=factor, metric=metric, levels=tuple(levels))


def _corrected(found: Sequence[Response]) -> list[Response]:
    effects = iter(holm([level.effect for one in found for level in one.levels if level.effect is not None]))
    return [
        replace(
            one,
            levels=tuple(
                level if level.effect is None else replace(level, effect=next(effects)) for level in one.levels
            ),
        )
        for one in found
    ]


def _interactions(samples: Mapping[tuple[Any, Any], Values], row0: Any, column0: Any) -> Iterator[Interaction]:
    for row, column in samples:
        four = [samples.get(key) for key in ((row, column), (row, column0), (row0, column), (row0, column0))]
        if row == row0 or column == column0 or any(one is None for one in four):
            continue
        both, first, second, neither = (one for one in four if one is not None)
        told = describe(both - first - second + neither)
        yield Interaction(row=row, column=column, value=told.mean, interval=told.bootstrap)
