"""The statistics of the comparisons: the paper's own rule, and what is expected beside it. SciPy's and statsmodels'.

Samples are results of instances, a fitness each; in a comparison entry i of both belongs to the same instance.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from math import isnan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.nonparametric import rank_compare_2indep
from statsmodels.stats.power import TTestIndPower
from statsmodels.stats.proportion import proportion_confint
from statsmodels.stats.weightstats import DescrStatsW

CONFIDENCE = 0.9  # of every interval: the paper's CI90
ALPHA = 0.1  # of every test: the paper's
POWER = 0.8  # at which a difference counts as one that so many instances would show
EFFICIENCY = 3 / np.pi  # of the Mann-Whitney test to the t test, asymptotically, for normal samples
RESAMPLES = 4999  # of every bootstrap; its random numbers are the same in every call
_PERMUTATIONS = 9999

Values = NDArray[np.float64]


class Interval(NamedTuple):
    """A 90 % confidence interval."""

    low: float
    high: float

    def overlaps(self, other: Interval) -> bool:
        """Do the two share a value?"""
        return self.low <= other.high and other.low <= self.high

    def holds(self, value: float) -> bool:
        """Does it hold the value?"""
        return self.low <= value <= self.high


@dataclass(frozen=True, kw_only=True)
class Description:
    """One sample. What cannot be said of so few or of equal values is None.

    Attributes:
        count: number of instances.
        mean, sd: mean and sample standard deviation.
        interval: of the mean, Student's t; the paper's CI90.
        bootstrap: of the mean, bias-corrected and accelerated bootstrap (BCa).
        delivering: share of instances above -1, which deliver anything, with its Wilson interval.
        successful: share above 0, which deliver a greater share of the packets than they use of the time; likewise.
    """

    count: int
    mean: float
    sd: float | None
    interval: Interval | None
    bootstrap: Interval | None
    delivering: float
    delivering_interval: Interval
    successful: float
    successful_interval: Interval


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Two samples, x and y, of the same instances. What cannot be said of so few or of equal values is None.

    Attributes:
        count: number of instances.
        difference: mean of x less mean of y; above 0 if x is better.
        bootstrap: its BCa interval over instances.
        p_mann_whitney: two-sided Mann-Whitney U test.
        p_holm: the same after Holm's correction over the family; set by `holm`.
        p_wilcoxon: two-sided paired Wilcoxon signed-rank test.
        a12: Vargha and Delaney's A: chance that a result of x is better than one of y, ties counting half.
        a12_interval: of that, from Brunner and Munzel's variance; None if the samples do not overlap at all.
        significant: the paper's rule: means differ, the CI90s do not overlap, and p_mann_whitney < 0.1.
        sd: pooled standard deviation of the two.
        visible: the least true difference that the Mann-Whitney test would show (p < 0.1) four times out of five.
    """

    count: int
    difference: float
    bootstrap: Interval | None
    p_mann_whitney: float | None
    p_wilcoxon: float | None
    a12: float
    a12_interval: Interval | None
    significant: bool
    sd: float | None = None
    visible: float | None = None
    p_holm: float | None = None


def describe(values: Sequence[float] | Values) -> Description:
    """Describe one sample of at least one value."""
    sample = np.asarray(values, dtype=np.float64)
    delivering, successful = int((sample > -1).sum()), int((sample > 0).sum())
    return Description(
        count=len(sample),
        mean=float(sample.mean()),
        sd=float(sample.std(ddof=1)) if len(sample) > 1 else None,
        interval=mean_interval(sample),
        bootstrap=_bootstrap(sample),
        delivering=delivering / len(sample),
        delivering_interval=share_interval(delivering, len(sample)),
        successful=successful / len(sample),
        successful_interval=share_interval(successful, len(sample)),
    )


def mean_interval(values: Values) -> Interval | None:
    """Student's t interval of the mean; None for fewer than two values."""
    if len(values) < 2:
        return None
    return _interval(DescrStatsW(values).tconfint_mean(alpha=1 - CONFIDENCE))


def share_interval(count: int, of: int) -> Interval:
    """Wilson's interval of a share."""
    low, high = proportion_confint(count, of, alpha=1 - CONFIDENCE, method="wilson")
    return Interval(max(0.0, float(low)), min(1.0, float(high)))


def compare(x: Sequence[float] | Values, y: Sequence[float] | Values) -> Comparison:
    """Compare two samples of the same instances; raises ValueError if they differ in length or are empty."""
    first, second = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if first.shape != second.shape or not len(first):
        raise ValueError(f"samples of {len(first)} and {len(second)} instances: they must be of the same instances")
    u, p = (float(value) for value in stats.mannwhitneyu(first, second, alternative="two-sided"))
    many = len(first) > 1
    sd = float(np.sqrt((first.var(ddof=1) + second.var(ddof=1)) / 2)) if many else None
    return Comparison(
        count=len(first),
        difference=float(first.mean() - second.mean()),
        bootstrap=_bootstrap(first - second),
        p_mann_whitney=p if many else None,
        p_wilcoxon=wilcoxon(first - second) if many else None,
        a12=u / (len(first) * len(second)),
        a12_interval=_a12_interval(first, second),
        significant=_significant(first, second, p),
        sd=sd,
        visible=None if not sd else sd * _effect(len(first)),
    )


def power(difference: float, one: Comparison) -> float | None:
    """Chance that as many instances show a true difference (two-sided Mann-Whitney test, p < 0.1).

    Of normal samples with the pooled standard deviation of the comparison; None where that is not known or 0.
    """
    if not one.sd:
        return None
    found = float(TTestIndPower().power(abs(difference) / one.sd, one.count * EFFICIENCY, ALPHA))
    return 1.0 if isnan(found) else found  # SciPy's noncentral t gives out where the power is 1 to nine digits


@cache
def _effect(count: int) -> float:
    """The difference in standard deviations that so many instances show with POWER."""
    return float(TTestIndPower().solve_power(nobs1=count * EFFICIENCY, alpha=ALPHA, power=POWER))


def holm(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """The comparisons of one family with Holm's correction of their Mann-Whitney p."""
    from dataclasses import replace

    known = [one.p_mann_whitney for one in comparisons if one.p_mann_whitney is not None]
    if not known:
        return list(comparisons)
    corrected = iter(multipletests(known, alpha=ALPHA, method="holm")[1])
    return [one if one.p_mann_whitney is None else replace(one, p_holm=float(next(corrected))) for one in comparisons]


def holm_of(values: Sequence[float | None]) -> list[float | None]:
    """p of one family with Holm's correction; None stays."""
    known = [one for one in values if one is not None]
    corrected = iter(multipletests(known, alpha=ALPHA, method="holm")[1]) if known else iter(())
    return [None if one is None else float(next(corrected)) for one in values]


def contrast(x: Values, y: Values) -> tuple[float, Interval | None]:
    """Difference of the means of two samples that share no instances, and its BCa interval."""
    difference = float(x.mean() - y.mean())
    if len(x) < 2 or len(y) < 2:
        return difference, None
    return difference, resampled((x, y), lambda a, b, axis: a.mean(axis=axis) - b.mean(axis=axis))


def _significant(x: Values, y: Values, p: float) -> bool:
    """The paper: higher mean, no overlap of the CI90s, and p of the pair less than 0.1."""
    first, second = mean_interval(x), mean_interval(y)
    if first is None or second is None:
        return False
    return x.mean() != y.mean() and not first.overlaps(second) and p < ALPHA


def wilcoxon(differences: Values) -> float:
    """p of the two-sided signed-rank test; of equal pairs it is 1: nothing speaks for a difference."""
    if not differences.any():
        return 1.0
    return float(stats.wilcoxon(differences, alternative="two-sided").pvalue)


def permuted(x: Values, y: Values) -> float | None:
    """p of the paired permutation test of the mean difference, two-sided: signs of differences at random.

    Unlike ranks it asks about the mean: where one is a little better in most pairs and far worse in a few, the two can
    point to different sides. The same in every call; None for fewer than two pairs.
    """
    differences = x - y
    if len(differences) < 2:
        return None
    if not differences.any():
        return 1.0
    found = stats.permutation_test(
        (differences,),
        np.mean,
        permutation_type="samples",
        vectorized=True,
        n_resamples=_PERMUTATIONS,
        rng=np.random.default_rng(0),
    )
    return float(found.pvalue)


def _a12_interval(x: Values, y: Values) -> Interval | None:
    if len(x) < 2:
        return None
    with _degenerate_allowed():
        low, high = rank_compare_2indep(x, y).conf_int(alpha=1 - CONFIDENCE)
    if not np.isfinite([low, high]).all():
        return None
    return Interval(max(0.0, float(low)), min(1.0, float(high)))


def _bootstrap(values: Values) -> Interval | None:
    return resampled((values,), np.mean) if len(values) > 1 else None


def resampled(
    samples: Sequence[Values],
    statistic: Callable[..., Any],
    *,
    method: str = "BCa",
    confidence: float = CONFIDENCE,
    resamples: int = RESAMPLES,
) -> Interval | None:
    """Bootstrap interval of a statistic of some samples, each drawn again from itself; the same in every call.

    `statistic` takes arrays [..., n], one to a sample, and their `axis`. None where equal values allow no interval.
    """
    with _degenerate_allowed():
        found = stats.bootstrap(
            samples,
            statistic,
            n_resamples=resamples,
            confidence_level=confidence,
            method=method,
            vectorized=True,
            rng=np.random.default_rng(0),
        ).confidence_interval
    return _interval(found)


def _interval(pair: Any) -> Interval | None:
    low, high = (float(value) for value in pair)
    return Interval(low, high) if np.isfinite([low, high]).all() else None


@contextmanager
def _degenerate_allowed() -> Iterator[None]:
    """Equal values and samples that do not overlap have no variance: the libraries warn and give NaN."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        yield
