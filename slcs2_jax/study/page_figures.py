"""The figures of the page of a study, as plain values for the page's program; plot.js says how one looks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from slcs2_jax.config.field import show
from slcs2_jax.results.arm import CELLS, PLACES, arm_title
from slcs2_jax.study.paper import printed_mean
from slcs2_jax.study.response import Grid, Response, grids, responses
from slcs2_jax.study.statistics import Interval, Values, mean_interval
from slcs2_jax.study.study import BEST, FRESH, METRICS, MOST_ARMS, Contest, Study

Figure = dict[str, Any]

MEASURES = {BEST: "best fitness", FRESH: "mean fresh fitness"}  # for axes
_MOST_GENERATIONS = 400  # that are drawn of a curve


def figures(study: Study) -> list[Figure]:
    """All of a study, each with its `metric`; None for those that show both or neither."""
    found: list[Figure] = []
    few = len(study.arms) <= MOST_ARMS
    for metric in METRICS:
        if few and study.descriptions(metric):
            found.append(_fitness(study, metric))
        if few and study.comparisons(metric):
            found += [_differences(study, metric), _effects(study, metric)]
        found += [_response(one, study) for one in responses(study, metric)]
        found += [_grid(one, study) for one in grids(study, metric)]
    return [*found, *(_curves(study) if few and study.generations else ())]


def _fitness(study: Study, metric: str) -> Figure:
    """Mean and CI90 of every arm in every world, with what the paper prints."""
    told = study.descriptions(metric)
    places = [place for place in PLACES if any(at == place for _, at in told)]
    series = []
    for number, arm in enumerate(study.arms):
        own = [told.get((arm, place)) for place in places]
        means, intervals = (
            [None if one is None else one.mean for one in own],
            [None if one is None else one.interval for one in own],
        )
        series.append({**_series(arm_title(arm), means, intervals), "like": number})
        printed = [printed_mean(study.name, arm, place.name) for place in places]
        if any(value is not None for value in printed):
            label = f"{arm_title(arm)}, printed in the paper"
            series.append({"label": label, "ys": printed, "kind": "rings", "like": number})
    return {
        "metric": metric,
        "name": f"{study.name}_{metric}",
        "title": f"Fitness: {METRICS[metric]}",
        "caption": f"Mean over instances and its 90 % confidence interval, {study.when}.",
        "x": {"label": "world", "names": [place.title for place in places]},
        "y": {"label": MEASURES[metric]},
        "series": series,
    }


def _differences(study: Study, metric: str) -> Figure:
    return _contests(
        study,
        metric,
        name="differences",
        title=f"{arm_title(study.reference)} less each other arm: {METRICS[metric]}",
        caption="Difference of the means over the same instances and its 90 % interval (BCa bootstrap); above 0 "
        f"{arm_title(study.reference)} is better.",
        label="difference in fitness",
        level=0.0,
    )


def _effects(study: Study, metric: str) -> Figure:
    return _contests(
        study,
        metric,
        name="effects",
        title=f"Effect size A12 of {arm_title(study.reference)} against each other arm: {METRICS[metric]}",
        caption=f"Chance that a result of {arm_title(study.reference)} is the better one, with its 90 % interval; 0.5 "
        "is no effect. Without an interval: the two do not overlap at all.",
        label="A12",
        level=0.5,
    )


def _contests(study: Study, metric: str, *, name: str, title: str, caption: str, label: str, level: float) -> Figure:
    found = study.comparisons(metric)
    places = [place for place in PLACES if any(contest.place == place for contest in found)]
    series = []
    for arm in study.arms[1:]:
        own = [found.get(Contest(arm, place)) for place in places]
        attributes = ("a12", "a12_interval") if name == "effects" else ("difference", "bootstrap")
        values, intervals = ([None if one is None else getattr(one, each) for one in own] for each in attributes)
        series.append(_series(f"against {arm_title(arm)}", values, intervals))
    return {
        "metric": metric,
        "name": f"{study.name}_{metric}_{name}",
        "title": title,
        "caption": caption,
        "x": {"label": "world", "names": [place.title for place in places]},
        "y": {"label": label},
        "series": series,
        "level": level,
    }


def _response(one: Response, study: Study) -> Figure:
    """One algorithm's response in one world to one setting."""
    told = [level.description for level in one.levels]
    values = [level.value for level in one.levels]
    name = one.factor.name.replace(".", "_")
    x: dict[str, Any] = {"label": one.factor.label}
    if not one.factor.numeric:
        x["names"] = [show(value) for value in values]
    return {
        "metric": one.metric,
        "name": f"{study.name}_{one.place.name}_{one.algorithm}_{name}_{one.metric}",
        "title": f"{one.factor.name}: {arm_title(one.algorithm)}, {one.place.title}",
        "caption": f"{METRICS[one.metric]}: mean of {told[0].count} instances and its 90 % confidence interval, the "
        f"other settings unchanged; compared with {show(one.base)}.",
        "x": x,
        "y": {"label": MEASURES[one.metric]},
        **({"xs": values} if one.factor.numeric else {}),
        "series": [
            _series(arm_title(one.algorithm), [each.mean for each in told], [each.interval for each in told], "joined")
        ],
    }


def _grid(one: Grid, study: Study) -> Figure:
    """The means over two settings as a map of colours."""
    rows, columns = one.rows, one.columns
    cells = [[_number(one.means.get((row, column))) for column in columns.values] for row in rows.values]
    name = f"{rows.name}_and_{columns.name}".replace(".", "_")
    return {
        "metric": one.metric,
        "name": f"{study.name}_{one.place.name}_{one.algorithm}_{name}_{one.metric}",
        "title": f"{rows.name} and {columns.name}: {arm_title(one.algorithm)}, {one.place.title}",
        "caption": f"{METRICS[one.metric]}, mean of {one.count} instances; yellow is the greatest, blue the least.",
        "x": {"label": columns.label, "names": [show(value) for value in columns.values]},
        "y": {"label": rows.label, "names": [show(value) for value in rows.values]},
        "cells": cells,
    }


def _curves(study: Study) -> Iterator[Figure]:
    """Best so far by generation in each world, a band for each arm."""
    every = -(-study.generations // _MOST_GENERATIONS)
    at = sorted({*range(0, study.generations, every), study.generations - 1})
    for cell in CELLS:
        seeds = study.seeds(cell, BEST)
        if not seeds:
            continue
        series = []
        for arm in study.arms:
            curves = study.curves(arm, cell)
            if len(curves):
                means, intervals = _band(curves[:, at])
                series.append(_series(arm_title(arm), means, intervals, "line"))
        yield {
            "metric": None,
            "name": f"{study.name}_{cell.name}_curves",
            "title": f"Search in {cell.title}",
            "caption": f"{METRICS[BEST]} so far: mean of {len(seeds)} instances and its 90 % confidence interval.",
            "x": {"label": "generation"},
            "y": {"label": "best fitness so far"},
            "xs": [generation + 1 for generation in at],
            "series": series,
        }


def _band(curves: Values) -> tuple[list[float], list[Interval | None]]:
    return curves.mean(axis=0).tolist(), [mean_interval(column) for column in curves.T]


def _series(
    label: str, values: Sequence[float | None], intervals: Sequence[Interval | None], kind: str = "dots"
) -> dict[str, Any]:
    return {
        "label": label,
        "ys": [_number(value) for value in values],
        "low": [_number(one.low if one else None) for one in intervals],
        "high": [_number(one.high if one else None) for one in intervals],
        "kind": kind,
    }


def _number(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(f"{value:.6g}")
