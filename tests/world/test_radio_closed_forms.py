"""Outage and capture of every fading against closed forms, by the functions that every step of the simulator calls.

Signals have mean powers S and I over a link of interest and an interferer's; noise is N, the threshold theta. Closed
forms: Goldsmith, Wireless Communications (2005), section 6.3 (outage); Simon and Alouini, Digital Communication over
Fading Channels (2nd ed. 2005), chapter 10 (co-channel interference).
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import integrate, special, stats

from slcs2_jax.config import Radio
from slcs2_jax.grammar.language import Language
from slcs2_jax.suite.worlds import load_suite
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world import randomness
from slcs2_jax.world.arena import stack
from slcs2_jax.world.radio import RadioParameters, decodable, received_power
from slcs2_jax.world.randomness import Purpose

COUNT = 200_000
K, M = 4.0, 2.5  # of the Rician and the Nakagami fading

FADINGS = {
    "none": Radio(fading="none"),
    "lognormal": Radio(fading="lognormal"),
    "rayleigh": Radio(fading="rayleigh"),
    "rician": Radio(fading="rician", rician_k=K),
    "nakagami": Radio(fading="nakagami", nakagami_m=M),
}
# Of the gain in linear power: its distribution function and density.
GAINS = {
    "lognormal": stats.lognorm(4 * np.log(10) / 10),
    "rayleigh": stats.expon(),
    "rician": stats.ncx2(2, 2 * K, scale=1 / (2 * (K + 1))),
    "nakagami": stats.gamma(M, scale=1 / M),
}


def mean_mw(distance: float, radio: Radio) -> float:
    """By hand: P_t - PL0 - 10 gamma log10(d)."""
    dbm = radio.power_dbm - radio.reference_loss_db - 10 * radio.path_loss_exponent * np.log10(distance)
    return 10 ** (dbm / 10)


def mw(dbm: float) -> float:
    return 10 ** (dbm / 10)


def drawn(name: str, distance: float, link: int) -> jax.Array:
    """Received powers, mW, of many steps over a link."""
    radio = RadioParameters.of(FADINGS[name])

    def words(k: int) -> jax.Array:
        stream = randomness.stream(jnp.array([5, 6], jnp.uint32), jnp.int32(100 * link + k), Purpose.FADING)
        return randomness.bits(stream, jnp.arange(COUNT, dtype=jnp.uint32))

    squared = jnp.full(COUNT, np.float32(distance**2))
    return received_power(squared, jnp.float32(0), radio.fading.gain(words), radio)


def close(share: float, expected: float) -> None:
    """Within five standard errors of a share of so many draws."""
    assert share == pytest.approx(expected, abs=5 * np.sqrt(max(expected * (1 - expected), 1e-6) / COUNT))


@pytest.mark.parametrize("name", GAINS)
@pytest.mark.parametrize("distance", [100.0, 150.0, 200.0])
def test_outage(name, distance):
    """A signal alone is lost where it falls below P_rs, which is above the noise by more than the threshold."""
    radio = RadioParameters.of(FADINGS[name])
    got = decodable(drawn(name, distance, 0), jnp.float32(0), radio)
    needed = mw(FADINGS[name].receive_threshold_dbm) / mean_mw(distance, FADINGS[name])
    close(1 - float(np.mean(got)), float(GAINS[name].cdf(needed)))


@pytest.mark.parametrize(("distance", "received"), [(163.0, True), (164.0, False)])
def test_without_fading_reach_is_net(distance, received):
    radio = RadioParameters.of(FADINGS["none"])
    assert bool(np.all(decodable(drawn("none", distance, 0), jnp.float32(0), radio))) is received
    assert 163 < float(radio.network_range) < 164


def capture(name: str, ratio: float) -> float:
    """P(g1 S >= theta g2 I) of independent gains, without noise; ratio: theta I / S."""
    if name == "lognormal":
        return float(stats.norm.cdf(-10 * np.log10(ratio) / (4 * np.sqrt(2))))
    if name == "rayleigh":
        return 1 / (1 + ratio)
    if name == "nakagami":
        return float(special.betainc(M, M, 1 / (1 + ratio)))
    gain = GAINS["rician"]
    return float(integrate.quad(lambda g: gain.pdf(g) * gain.sf(ratio * g), 0, np.inf, limit=200)[0])


@pytest.mark.parametrize("name", GAINS)
@pytest.mark.parametrize(("near", "far"), [(20.0, 50.0), (20.0, 35.0), (30.0, 30.0)])
def test_capture_of_the_stronger_of_two_signals(name, near, far):
    """So near that neither noise nor P_rs counts: power alone decides."""
    radio = RadioParameters.of(FADINGS[name])
    got = decodable(drawn(name, near, 1), drawn(name, far, 2), radio)
    theta = mw(FADINGS[name].sinr_threshold_db)
    ratio = theta * mean_mw(far, FADINGS[name]) / mean_mw(near, FADINGS[name])
    close(float(np.mean(got)), capture(name, ratio))


def test_sinr_with_noise_and_interference_under_rayleigh_fading():
    """P(g1 S >= theta (N + g2 I)) = exp(-theta N / S) / (1 + theta I / S), P_rs out of the way."""
    said = dataclasses.replace(FADINGS["rayleigh"], receive_threshold_dbm=-120.0)
    radio = dataclasses.replace(RadioParameters.of(said))
    near, far = 150.0, 400.0
    got = decodable(drawn("rayleigh", near, 1), drawn("rayleigh", far, 2), radio)
    theta, noise, signal, other = mw(10), mw(said.noise_dbm), mean_mw(near, said), mean_mw(far, said)
    close(float(np.mean(got)), np.exp(-theta * noise / signal) / (1 + theta * other / signal))


@pytest.mark.parametrize("name", FADINGS)
def test_whom_a_swarm_hears_is_as_outage_says(name):
    """Two agents 150 m apart in 20 000 worlds, by a whole observed time-step: a beacon is a signal alone."""
    world = load_suite().worlds["few"]
    settings = dataclasses.replace(world.settings(5_180_000), radio=FADINGS[name])
    settings = dataclasses.replace(settings, swarm=dataclasses.replace(settings.swarm, agents=2))
    place = np.array([[400, 0], [400, 150]], np.float32)
    scenario = dataclasses.replace(world.scenario(5_180_000), start=place)
    worlds = 20_000
    one = stack([scenario], [(0,)], capacity=(0, 0), width=1)
    arena = jax.tree.map(lambda leaf: jnp.repeat(jnp.asarray(leaf), worlds, axis=-1), one)
    physics = Physics.of(settings, Language())
    key = jnp.stack([jnp.arange(worlds, dtype=jnp.uint32), jnp.full(worlds, 7, jnp.uint32)])
    _, seen = swarm.observe(swarm.begin(arena, key, physics), arena, physics)
    heard = np.asarray(seen.view.heard)
    np.testing.assert_array_equal(heard[0, 1], heard[1, 0])  # links are reciprocal
    needed = mw(-82.0) / mean_mw(150.0, FADINGS[name])
    expected = float(GAINS[name].sf(needed)) if name in GAINS else 1.0
    assert heard[0, 1].mean() == pytest.approx(expected, abs=5 * np.sqrt(0.25 / worlds))
