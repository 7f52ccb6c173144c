"""Fading against the distributions it is named after, by SciPy; and that further words shift no draw."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from slcs2_jax.config import InputError, Radio
from slcs2_jax.config.registry import KINDS, register
from slcs2_jax.world import randomness
from slcs2_jax.world.fading import TRIES, LogNormal, Nakagami, NoFading, Rayleigh, Rician
from slcs2_jax.world.radio import RadioParameters, received_power
from slcs2_jax.world.randomness import Purpose

COUNT = 200_000
LEAST_P = 1e-4  # the words are fixed, so these tests are deterministic


def words(k):
    stream = randomness.stream(jnp.array([3, 4], jnp.uint32), jnp.int32(k), Purpose.FADING)
    return randomness.bits(stream, jnp.arange(COUNT, dtype=jnp.uint32))


def gains(part, **settings):
    """Linear gains of many links."""
    made = part.of(Radio(**settings))
    return 2.0 ** np.asarray(jax.jit(lambda made: made.gain(words))(made), np.float64)


def check(gains, distribution):
    assert np.isfinite(gains).all()
    assert stats.kstest(gains, distribution.cdf).pvalue > LEAST_P
    assert gains.mean() == pytest.approx(distribution.mean(), abs=5 * distribution.std() / np.sqrt(COUNT))


def test_rayleigh_power_is_exponential():
    check(gains(Rayleigh), stats.expon())


@pytest.mark.parametrize("k", [0.0, 0.5, 3.0, 10.0, 100.0])
def test_rician_power_is_noncentral_chi_squared(k):
    distribution = stats.ncx2(2, 2 * k, scale=1 / (2 * (k + 1))) if k else stats.expon()
    assert distribution.mean() == pytest.approx(1)
    check(gains(Rician, rician_k=k), distribution)


@pytest.mark.parametrize("m", [0.5, 0.75, 0.999, 1.0, 1.5, 3.0, 40.0])
def test_nakagami_power_is_gamma(m):
    distribution = stats.gamma(m, scale=1 / m)
    assert distribution.mean() == pytest.approx(1)
    check(gains(Nakagami, nakagami_m=m), distribution)


def test_marsaglia_and_tsangs_method_rarely_runs_out_of_tries():
    """At m = 1, the worst, a try fails with chance 0.048: of so many links one or two take the value put in place."""
    found = gains(Nakagami, nakagami_m=1.0)
    never = np.isclose(found, 1.0, rtol=1e-7).sum()
    assert never <= 12
    assert 0.049**TRIES < 6e-6


def test_the_papers_shadowing_is_normal_in_decibels_with_mean_0():
    decibels = 10 * np.log10(gains(LogNormal, shadowing_db=4.0))
    assert stats.kstest(decibels, stats.norm(0, 4).cdf).pvalue > LEAST_P


def test_without_fading_there_is_the_mean():
    assert NoFading.of(Radio()).gain(words) is None
    radio = RadioParameters.of(Radio(fading="none"))
    squared = jnp.float32(80.0**2)
    power = received_power(squared, jnp.float32(0), radio.fading.gain(words), radio)
    assert 10 * np.log10(float(power)) == pytest.approx(20 - 40.05 - 28 * np.log10(80), abs=1e-4)


@pytest.mark.parametrize(("name", "part"), [("none", NoFading), ("lognormal", LogNormal), ("rayleigh", Rayleigh),
                                            ("rician", Rician), ("nakagami", Nakagami)])  # fmt: skip
def test_each_is_chosen_by_its_name(name, part):
    assert type(RadioParameters.of(Radio(fading=name)).fading) is part


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Coin:
    """Half the power, or twice."""

    db: jax.Array

    @classmethod
    def of(cls, radio):
        return cls(jnp.float32(1.0))

    def gain(self, words):
        return jnp.where(words(0) >> np.uint32(31) == 1, self.db, -self.db)


@pytest.fixture
def coin():
    register("fading", "coin")(Coin)
    yield
    KINDS["fading"].forget("coin")


def test_a_users_fading_is_one_class(coin):
    radio = RadioParameters.of(Radio(fading="coin"))
    found = 2.0 ** np.asarray(radio.fading.gain(words))
    assert set(np.unique(found)) == {0.5, 2.0}


def test_what_is_not_registered_is_refused():
    with pytest.raises(InputError, match=r"radio\.fading=coin: accepted is one of none, lognormal, rayleigh, rician"):
        Radio(fading="coin")
