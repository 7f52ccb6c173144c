"""The table's statistics against figures done by hand, and against what they must not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from slcs2_jax.suite.statistics import LEVELS, improvement, interquartile_mean, mean, paired_p, profile

RNG = np.random.default_rng(0)
EASY, HARD = RNG.normal(0.8, 0.05, 30), RNG.normal(-0.5, 0.3, 30)


def test_the_mean_counts_each_kind_of_world_alike():
    assert mean([np.ones(3), np.zeros(30)]).value == 0.5


def test_the_interval_is_that_of_a_mean_of_strata():
    found = mean([EASY, HARD])
    error = np.sqrt(EASY.var(ddof=1) / 30 + HARD.var(ddof=1) / 30) / 2
    assert found.value == pytest.approx((EASY.mean() + HARD.mean()) / 2)
    assert found.high - found.low == pytest.approx(2 * 1.96 * error, rel=0.1)


def test_strata_are_not_mixed():
    """Were all scores drawn from one urn, the interval would be as wide as the kinds of worlds differ."""
    found = mean([np.full(30, 1.0), np.full(30, -1.0)])
    assert (found.value, found.low, found.high) == (0, 0, 0)


def test_the_interquartile_mean_leaves_out_a_quarter_at_each_end():
    found = interquartile_mean([np.array([0.0, 1.0, 2.0, 100.0])])
    assert found.value == 1.5
    assert interquartile_mean([EASY, HARD]).value == pytest.approx(stats.trim_mean([*EASY, *HARD], 0.25))


def test_improvement_compares_within_a_world_and_halves_ties():
    first, second = np.array([0.1, 0.5, 0.9, 0.2]), np.array([0.0, 0.5, 1.0, 0.1])
    assert improvement([(first, second)]).value == (1 + 0.5 + 0 + 1) / 4
    assert improvement([(first, second), (second, first)]).value == 0.5
    with pytest.raises(ValueError, match="the same worlds"):
        improvement([(first, second[:3])])


def test_one_world_has_no_interval():
    assert mean([np.array([0.3])]) == (0.3, None, None)


def test_a_profile_is_the_share_above():
    value, low, high = profile([EASY, HARD])
    place = int(np.searchsorted(LEVELS, 0.0))
    assert value[place] == pytest.approx(((LEVELS[place] < EASY).mean() + (LEVELS[place] < HARD).mean()) / 2)
    assert value == sorted(value, reverse=True)
    assert all(a - 1e-9 <= b <= c + 1e-9 for a, b, c in zip(low, value, high, strict=True))
    assert high[place] > low[place]


def test_the_paired_test_is_wilcoxons():
    assert paired_p(EASY, EASY) == 1.0
    shifted = EASY + 0.01
    assert paired_p(shifted, EASY) == pytest.approx(stats.wilcoxon(shifted - EASY).pvalue)
