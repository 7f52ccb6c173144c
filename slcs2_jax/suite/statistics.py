"""The statistics of the table: what reinforcement learning asks for today, and tests paired by world.

Interquartile mean, stratified bootstrap intervals, probability of improvement and performance profiles as Agarwal,
Schwarzer, Castro, Courville and Bellemare, Deep reinforcement learning at the edge of the statistical precipice,
NeurIPS 2021. The strata are the kinds of worlds; within one, test worlds are drawn again. A score is the mean over
trainings and deployments in one test world, so intervals speak of further worlds; how far trainings differ is a figure
of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from slcs2_jax.study.statistics import resampled, wilcoxon

CONFIDENCE = 0.95
RESAMPLES = 2000  # of every bootstrap; its random numbers are the same in every call
LEVELS = np.linspace(-1.0, 1.0, 81)  # of fitness, of a performance profile

Scores = NDArray[np.float64]  # of one entry in the test worlds of one kind, [S]


class Estimate(NamedTuple):
    """A figure and its 95 % interval; no interval where there is too little to draw from."""

    value: float
    low: float | None = None
    high: float | None = None


def mean(strata: Sequence[Scores]) -> Estimate:
    """The mean over kinds of worlds of the mean in each."""
    return _estimate(strata, lambda drawn: np.mean([one.mean(axis=-1) for one in drawn], axis=0))


def interquartile_mean(strata: Sequence[Scores]) -> Estimate:
    """The mean of the middle half of all scores: neither a hopeless world nor an easy one decides it."""

    def middle(drawn: Sequence[Scores]) -> Any:
        every = np.concatenate(drawn, axis=-1)
        return stats.trim_mean(every, 0.25, axis=-1)

    return _estimate(strata, middle)


def improvement(pairs: Sequence[tuple[Scores, Scores]]) -> Estimate:
    """The chance that the first is better than the second in the same world, ties counting half, over kinds of worlds.

    Raises ValueError if the scores of a pair are not of the same worlds.
    """
    wins = []
    for first, second in pairs:
        if first.shape != second.shape:
            raise ValueError(f"scores of {len(first)} and {len(second)} worlds: they must be of the same worlds")
        wins.append((first > second) + 0.5 * (first == second))
    return mean(wins)


def profile(strata: Sequence[Scores]) -> tuple[list[float], list[float], list[float]]:
    """The share of scores above each of `LEVELS`, the mean over kinds of worlds; and its interval, low and high."""
    above = [(one > LEVELS[:, None]).astype(np.float64) for one in strata]  # [levels, S] each
    value = np.mean([one.mean(axis=-1) for one in above], axis=0)
    rng = np.random.default_rng(0)
    drawn = np.zeros((RESAMPLES, len(LEVELS)))
    for one in above:
        counts = rng.multinomial(one.shape[1], np.full(one.shape[1], 1 / one.shape[1]), size=RESAMPLES)
        drawn += counts @ one.T / one.shape[1]
    tail = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(drawn / len(above), [tail, 100 - tail], axis=0)
    return value.tolist(), low.tolist(), high.tolist()


def paired_p(first: Scores, second: Scores) -> float:
    """Two-sided Wilcoxon signed-rank test of scores in the same worlds; 1 where all are equal."""
    if first.shape != second.shape:
        raise ValueError(f"scores of {len(first)} and {len(second)} worlds: they must be of the same worlds")
    return wilcoxon(first - second)


def _estimate(strata: Sequence[Scores], statistic: Callable[[Sequence[Scores]], Any]) -> Estimate:
    """A statistic of all strata and its percentile bootstrap, each stratum drawn again from itself.

    statistic: of arrays [..., S], one to a stratum, along their last axis.
    """
    value = float(statistic(strata))
    if min(len(one) for one in strata) < 2:
        return Estimate(value)

    def of_all(*drawn: Scores, axis: int = -1) -> Any:
        return statistic([np.moveaxis(one, axis, -1) for one in drawn])

    found = resampled(strata, of_all, method="percentile", confidence=CONFIDENCE, resamples=RESAMPLES)
    return Estimate(value) if found is None else Estimate(value, *found)
