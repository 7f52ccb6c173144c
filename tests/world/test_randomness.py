"""Draws named by (key, time-step, purpose, index): their bits, their statistics, and the normal deviates."""

from __future__ import annotations

import itertools
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import special, stats

from slcs2_jax.world import randomness
from slcs2_jax.world.randomness import Purpose

COUNT = 1 << 17
# The seeds are fixed, so these tests are deterministic; a sound generator fails none of them by more than this.
LEAST_P = 1e-4


@partial(jax.jit, static_argnums=2)
def draw(key, t, purpose, index):
    return randomness.bits(randomness.stream(key, t, purpose), index)


def words(key=(1, 2), t=0, purpose=Purpose.SHADOWING, index=0):
    """Any of the arguments may be an array: time-steps and keys are batch axes, the index is a leading one."""
    key = jnp.stack([jnp.asarray(k, jnp.uint32) for k in key])
    return np.asarray(draw(key, jnp.asarray(t, jnp.int32), purpose, jnp.asarray(index, jnp.uint32)))


def keys(count, seed=0):
    return np.random.default_rng(seed).integers(0, 2**32, (2, count), dtype=np.uint32)


def streams(first=0):
    """The same number of draws along each of the things that name them."""
    run = np.arange(first, first + COUNT)
    return {
        "index": words(index=run),
        "time": words(t=run),
        "key": words(key=keys(COUNT, seed=first)),
        "low key": words(key=(run, np.full(COUNT, 5))),
        "high key": words(key=(np.full(COUNT, 5), run)),
    }


def chi2_p(counts):
    return stats.chisquare(counts).pvalue


def by_hand(key, t, purpose, index):
    """The documented hash with Python's whole numbers."""
    full = 0xFFFFFFFF
    golden = 0x9E3779B9

    def mix(x, between=0):
        x ^= x >> 16
        x = x * 0x7FEB352D & full
        x ^= x >> 15
        x = (x + between) & full
        x = x * 0x846CA68B & full
        return x ^ x >> 16

    step = mix((key[0] + t) & full) ^ key[1]
    low = mix((step + purpose * golden) & full)
    high = mix((low + key[0]) & full)
    return mix(low ^ (index * golden & full), high)


@pytest.mark.parametrize("purpose", [Purpose.SHADOWING, Purpose.COLLECT])
def test_bits_are_the_documented_hash(purpose):
    rng = np.random.default_rng(3)
    for _ in range(30):
        key = tuple(int(k) for k in rng.integers(0, 2**32, 2))
        t, index = int(rng.integers(0, 10**7)), int(rng.integers(0, 70_000))
        assert int(words(key, t, purpose, index)) == by_hand(key, t, int(purpose), index)


def test_mix_is_a_bijection_that_moves_half_of_the_bits():
    x = jnp.arange(1 << 16, dtype=jnp.uint32) << np.uint32(7)
    mixed = np.asarray(randomness.mix(x))
    assert len(np.unique(mixed)) == len(x)
    for bit in range(0, 32, 5):
        changed = np.bitwise_count(np.asarray(randomness.mix(x ^ np.uint32(1 << bit))) ^ mixed)
        assert changed.mean() == pytest.approx(16, abs=0.1)


@pytest.mark.parametrize("shift", [0, 8, 16, 24])
def test_every_byte_is_uniform_along_index_time_and_key(shift):
    for name, stream in streams().items():
        counts = np.bincount(stream >> shift & 0xFF, minlength=256)
        assert chi2_p(counts) > LEAST_P, name


@pytest.mark.parametrize("lag", [1, 2, 15, 16])
def test_neighbouring_draws_are_independent(lag):
    for name, stream in streams(first=1000).items():
        joint = (stream[:-lag] >> 28) * 16 + (stream[lag:] >> 28)
        assert chi2_p(np.bincount(joint, minlength=256)) > LEAST_P, name
        joint = (stream[:-lag] & 15) * 16 + (stream[lag:] >> 28)
        assert chi2_p(np.bincount(joint, minlength=256)) > LEAST_P, name


def test_purposes_are_independent():
    run = np.arange(COUNT)
    for axis in ("index", "t"):
        of = [words(purpose=p, **{axis: run}) >> 28 for p in Purpose]
        for one, other in itertools.combinations(of, 2):
            assert chi2_p(np.bincount(one * 16 + other, minlength=256)) > LEAST_P, axis


def test_time_steps_and_episodes_are_independent():
    index = np.arange(COUNT)
    first = words(index=index) >> 28
    for other in (words(index=index, t=1), words((1, 3), index=index), words((2, 2), index=index)):
        assert chi2_p(np.bincount(first * 16 + (other >> 28), minlength=256)) > LEAST_P


def test_a_key_of_the_last_step_is_not_the_next_ones():
    """Key and time enter differently: key + 1 at step t must not repeat key at step t + 1."""
    index = np.arange(64)
    assert not (words((7, 0), t=1, index=index) == words((8, 0), t=0, index=index)).any()


def test_draws_do_not_repeat_within_an_episode():
    table = words(t=np.arange(2000), index=np.arange(225)[:, None])
    collisions = table.size - len(np.unique(table))
    expected = table.size**2 / 2**33
    assert abs(collisions - expected) < 6 * np.sqrt(expected)


def test_the_same_bits_alone_and_in_any_batch():
    key, t, index = keys(9), np.arange(9) * 1000, np.arange(20)
    batch = words(key, t, Purpose.RULE, index[:, None])
    for b in (0, 4, 8):
        np.testing.assert_array_equal(batch[:, b], words(key[:, b], t[b], Purpose.RULE, index))
    np.testing.assert_array_equal(batch[:, ::-1], words(key[:, ::-1], t[::-1], Purpose.RULE, index[:, None]))


def deviates(word):
    return np.asarray(jax.jit(randomness.normal)(jnp.asarray(word, jnp.uint32)))


def test_normal_is_the_inverse_distribution_function_of_the_upper_24_bits():
    rng = np.random.default_rng(0)
    upper = np.concatenate([np.arange(2000), rng.integers(0, 1 << 24, 50_000), (1 << 24) - 1 - np.arange(2000)])
    word = (upper << 8 | rng.integers(0, 256, upper.size)).astype(np.uint32)
    exact = special.ndtri((upper + 0.5) / 2**24)
    np.testing.assert_allclose(deviates(word), exact, rtol=2e-6, atol=1e-6)


def test_normal_is_finite_and_symmetric_at_its_ends():
    ends = deviates([0, 255, 0xFFFFFFFF, 0xFFFFFF00])
    assert ends[0] == ends[1] == -ends[2] == -ends[3]
    assert 5.3 < ends[2] < 5.5


def test_normal_deviates_are_normal():
    for name, stream in streams(first=5).items():
        z = deviates(stream)
        assert stats.kstest(z, "norm").pvalue > LEAST_P, name
        assert abs(z.mean()) < 5 / np.sqrt(COUNT), name
        assert z.var() == pytest.approx(1, abs=5 * np.sqrt(2 / COUNT)), name
        assert abs(stats.skew(z)) < 5 * np.sqrt(6 / COUNT), name
        assert abs(stats.kurtosis(z)) < 5 * np.sqrt(24 / COUNT), name


def test_normal_deviates_of_neighbouring_links_are_uncorrelated():
    for name, stream in streams(first=6).items():
        z = deviates(stream).astype(np.float64)
        for lag in (1, 15, 225):
            assert abs(np.mean(z[:-lag] * z[lag:])) < 5 / np.sqrt(COUNT), name
