"""The statistics against figures worked by hand and published ones."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from slcs2_jax.study.statistics import Interval, compare, contrast, describe, holm, power, share_interval


def test_mean_and_student_interval():
    # t(0.95, 4) = 2.1318 (any table); sd = sqrt(2.5) / 10
    one = describe([0.1, 0.2, 0.3, 0.4, 0.5])
    half = 2.1318 * math.sqrt(2.5) / 10 / math.sqrt(5)
    assert (one.count, one.mean, one.sd) == (5, pytest.approx(0.3), pytest.approx(math.sqrt(2.5) / 10))
    assert one.interval == pytest.approx((0.3 - half, 0.3 + half), abs=1e-5)
    assert one.bootstrap is not None
    assert one.interval.low < one.bootstrap.low < 0.3 < one.bootstrap.high < one.interval.high


def test_one_value_has_no_spread_and_equal_values_no_bootstrap():
    one = describe([0.25])
    assert (one.mean, one.sd, one.interval, one.bootstrap) == (0.25, None, None, None)
    equal = describe([0.25, 0.25, 0.25])
    assert (equal.sd, equal.interval, equal.bootstrap) == (0.0, (0.25, 0.25), None)


def test_success_rates_and_wilson_interval():
    one = describe([-1.0, -0.5, 0.0, 0.2])
    assert (one.delivering, one.successful) == (0.75, 0.25)
    # Wilson: nothing of n gives the upper bound z2 / (n + z2), z = 1.6449
    assert share_interval(0, 10) == pytest.approx((0.0, 2.7055 / 12.7055), abs=1e-4)
    assert share_interval(10, 10) == pytest.approx((10 / 12.7055, 1.0), abs=1e-4)


def test_bootstrap_is_of_the_mean_and_corrects_for_skew():
    skewed = np.array([0.0] * 15 + [0.1, 0.2, 0.4, 0.8, 1.0])
    one = describe(skewed)
    assert one.bootstrap is not None
    # BCa is wider towards the tail, Student's interval is symmetric
    assert one.bootstrap.high - one.mean > 1.2 * (one.mean - one.bootstrap.low)
    assert describe(skewed) == one  # the same in every call


def test_vargha_delaney_counts_ties_half():
    # of nine pairs one is won (3 > 2) and two are tied
    assert compare([1.0, 2.0, 3.0], [2.0, 3.0, 4.0]).a12 == pytest.approx(2 / 9)
    assert compare([2.0, 3.0, 4.0], [1.0, 2.0, 3.0]).a12 == pytest.approx(7 / 9)


def test_a12_interval_lies_around_it_and_is_not_made_up_for_samples_apart():
    one = compare([0.5, 0.6, 0.7, 0.8], [0.1, 0.2, 0.3, 0.65])
    assert one.a12 == 14 / 16
    assert one.a12_interval is not None
    assert 0 <= one.a12_interval.low < one.a12 < one.a12_interval.high <= 1
    assert compare([0.5, 0.6], [0.1, 0.2]).a12_interval is None


def test_exact_p_of_samples_apart():
    # two-sided: 2 of the C(8, 4) = 70 orders, and 2 of the 2^4 = 16 signs
    one = compare([0.5, 0.6, 0.7, 0.8], [0.1, 0.21, 0.32, 0.43])
    assert one.p_mann_whitney == pytest.approx(2 / 70)
    assert one.p_wilcoxon == pytest.approx(2 / 16)
    assert one.difference == pytest.approx(0.65 - 0.265)


def test_published_examples():
    # age at diagnosis of four women and four of five men, four of the five men of an example in the manual of SciPy
    one = compare([19.0, 22.0, 16.0, 29.0], [20.0, 11.0, 17.0, 12.0])
    assert one.a12 * 16 == 13
    assert one.p_mann_whitney == pytest.approx(0.2)  # 14 of 70 orders are as far from 8 as 13
    # Darwin's maize, in eighths of an inch: Fisher (1935); signed-rank p = 0.0413
    gains = np.array([6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75], dtype=np.float64)
    assert compare(gains, np.zeros(15)).p_wilcoxon == pytest.approx(0.041259765625)


def test_the_pairs_are_those_of_the_same_instance():
    # every instance gains the same little, which only the paired test and the paired bootstrap see
    base = np.array([-0.8, -0.3, 0.1, 0.4, 0.7, 0.9])
    gain = np.array([0.011, 0.012, 0.013, 0.014, 0.015, 0.016])
    one = compare(base + gain, base)
    assert one.p_wilcoxon == pytest.approx(2 / 64)
    assert one.p_mann_whitney is not None
    assert one.p_mann_whitney > 0.5
    assert one.bootstrap is not None
    assert 0 < one.bootstrap.low < one.difference < one.bootstrap.high


def test_equal_samples_differ_in_nothing():
    one = compare([0.1, 0.2, 0.3], [0.1, 0.2, 0.3])
    assert (one.difference, one.p_wilcoxon, one.a12, one.significant, one.bootstrap) == (0, 1.0, 0.5, False, None)
    many = compare([0.5] * 12, [0.5] * 12)
    assert (many.p_mann_whitney, many.significant) == (1.0, False)


def test_a_single_instance_has_no_p():
    one = compare([0.5], [0.1])
    assert (one.p_mann_whitney, one.p_wilcoxon, one.significant) == (None, None, False)
    assert one.difference == pytest.approx(0.4)


def test_samples_of_different_instances_are_refused():
    with pytest.raises(ValueError, match="2 and 1 instances"):
        compare([0.1, 0.2], [0.1])


@pytest.mark.parametrize(
    ("x", "y", "significant"),
    [
        ([0.5, 0.6, 0.7, 0.8], [0.1, 0.2, 0.3, 0.4], True),
        ([0.1, 0.2, 0.3, 0.4], [0.5, 0.6, 0.7, 0.8], True),  # either way
        ([0.5, 0.6, 0.7], [0.1, 0.2, 0.3], False),  # intervals apart, but p = 0.1 is not below 0.1
        ([0.5, 0.51, 0.52, 2.0], [0.1, 0.2, 0.3, 0.4], False),  # p = 0.03, but one wide interval overlaps
    ],
)
def test_the_papers_rule(x, y, significant):
    assert compare(x, y).significant is significant


def test_intervals_that_touch_overlap():
    assert Interval(0.0, 0.5).overlaps(Interval(0.5, 1.0))
    assert Interval(0.5, 1.0).overlaps(Interval(0.0, 0.5))
    assert not Interval(0.0, 0.49).overlaps(Interval(0.5, 1.0))


def test_holm_over_the_family():
    # worked: sorted .005 x 4, .01 x 3, .03 x 2, .04 x 1, never falling
    raw = [0.01, 0.04, 0.03, 0.005]
    family = [replace(compare([0.5, 0.6], [0.1, 0.2]), p_mann_whitney=p) for p in raw]
    single = compare([0.5], [0.1])
    corrected = [one.p_holm for one in holm([*family, single])]
    assert corrected == [pytest.approx(0.03), pytest.approx(0.06), pytest.approx(0.06), pytest.approx(0.02), None]
    assert holm([single]) == [single]


def test_contrast_of_different_instances():
    difference, interval = contrast(np.array([0.6, 0.7, 0.8]), np.array([0.1, 0.2]))
    assert difference == pytest.approx(0.55)
    assert interval is not None
    assert interval.low < 0.55 < interval.high
    assert contrast(np.array([0.6]), np.array([0.1, 0.2])) == (pytest.approx(0.45), None)


def test_the_power_of_so_many_instances_is_that_of_simulated_ones():
    rng = np.random.default_rng(0)
    x, y = rng.normal(0.0, 1.0, (2, 10))
    one = compare(x, y)
    assert one.sd is not None
    assert one.visible is not None
    assert power(one.visible, one) == pytest.approx(0.8, abs=1e-6)
    pairs = one.sd * rng.normal(0.0, 1.0, (2, 4000, 10)) + one.visible * np.array([1, 0])[:, None, None]
    seen = stats.mannwhitneyu(*pairs, axis=1).pvalue < 0.1
    assert seen.mean() == pytest.approx(0.8, abs=0.03)
    assert power(0.0, one) == pytest.approx(0.1, abs=1e-6)
    assert [power(size * one.sd, one) for size in (4.0, 5.0, 50.0)] == pytest.approx([1.0] * 3)  # SciPy says NaN there


def test_equal_or_single_samples_have_no_power_that_could_be_told():
    assert compare([1.0, 1.0], [1.0, 1.0]).visible is None
    assert power(0.5, compare([1.0, 1.0], [1.0, 1.0])) is None
    assert compare([0.1], [0.2]).visible is None
