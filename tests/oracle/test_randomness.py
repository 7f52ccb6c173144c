"""Hash draws and normal numbers."""

import numpy as np
import pytest
from scipy import stats

from tests.oracle.randomness import draw, mix, normal, stream


def reference_draw(key0, key1, t, purpose, index):
    """The definition, in NumPy's wrapping arithmetic."""

    def scramble(x, add):
        x = x ^ (x >> np.uint32(16))
        x = x * np.uint32(0x7FEB352D)
        x = x ^ (x >> np.uint32(15))
        x = (x + add) * np.uint32(0x846CA68B)
        return x ^ (x >> np.uint32(16))

    word = lambda k: np.array([k], np.uint32)  # noqa: E731
    golden, zero = word(0x9E3779B9), word(0)
    a = scramble(word(key0) + word(t), zero) ^ word(key1)
    s1 = scramble(a + word(purpose) * golden, zero)
    s2 = scramble(s1 + word(key0), zero)
    return int(scramble(s1 ^ (word(index) * golden), s2)[0])


@pytest.mark.parametrize(
    "case", [(0, 0, 0, 0, 0), (1, 2, 3, 1, 5), (2**32 - 1, 2**31, 39999, 2, 1187), (7, 9, 1, 0, 4000)]
)
def test_draw_follows_its_definition_in_wrapping_words(case):
    *key, index = case
    assert draw(*stream(*key), index) == reference_draw(*case)


def test_mix_is_a_bijection_of_a_sample():
    assert len({mix(k * 65537) for k in range(5000)}) == 5000


def test_numpy_words_are_taken_as_keys():
    assert stream(np.uint32(2**32 - 1), np.uint32(5), 3, 1) == stream(2**32 - 1, 5, 3, 1)


def test_draws_are_uniform_and_purposes_independent():
    draws = np.array([[draw(*stream(1, 2, t, p), k) for t in range(40) for k in range(50)] for p in range(3)])
    counts = np.stack([np.bincount(row >> 28, minlength=16) for row in draws])
    assert stats.chisquare(counts, axis=1).pvalue.min() > 1e-3
    assert np.abs(np.corrcoef(draws) - np.eye(3)).max() < 0.08


def test_normal_has_the_quantiles_of_a_standard_normal():
    bits = np.linspace(0, 2**32 - 1, 4001).astype(np.int64)
    exact = stats.norm.ppf(((bits >> 8) + 0.5) / 2**24)
    np.testing.assert_allclose([normal(int(b)) for b in bits], exact, rtol=2e-6, atol=2e-7)


def test_normal_is_finite_and_odd_at_the_ends():
    assert normal(2**32 - 1) == -normal(0) == pytest.approx(5.4199, abs=1e-3)


def test_normal_draws_have_moments_of_a_standard_normal():
    words = stream(11, 12, 13, 0)
    sample = np.array([normal(draw(*words, k)) for k in range(20000)])
    assert abs(sample.mean()) < 0.03
    assert sample.std() == pytest.approx(1.0, abs=0.02)
    assert stats.kstest(sample, "norm").pvalue > 1e-3
