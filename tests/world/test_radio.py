"""Log-distance path loss, walls, shadowing, half power and the two conditions of reception."""

from __future__ import annotations

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import Radio
from slcs2_jax.world.radio import RadioParameters, decodable, milliwatts, received_power


def received_dbm(distance, walls=0.0, shadow=None, **settings):
    radio = RadioParameters.of(Radio(**settings))
    squared = jnp.asarray(np.square(distance), jnp.float32)
    gain = None if shadow is None else radio.fading.sigma * jnp.float32(shadow)
    power = received_power(squared, jnp.float32(walls), gain, radio)
    return 10 * np.log10(np.asarray(power, np.float64))


@pytest.mark.parametrize(("dbm", "mw"), [(0, 1), (20, 100), (-30, 1e-3), (-94, 10**-9.4), (3, 1.9953)])
def test_milliwatts(dbm, mw):
    assert milliwatts(dbm) == pytest.approx(mw, rel=1e-4)


@pytest.mark.parametrize(
    ("distance", "watts"), [(10, 4.98265e-9), (20, 6.22831e-10), (40, 7.78539e-11), (80, 9.73173e-12)]
)
def test_the_known_values_of_ns3s_log_distance_model(distance, watts):
    """ns-3, propagation-loss-model-test-suite.cc: 0.05035702 W, 40.045997 dB at 1 m, exponent 3."""
    sent = 10 * np.log10(0.05035702e3)
    dbm = received_dbm(distance, power_dbm=sent, reference_loss_db=40.045997, path_loss_exponent=3.0)
    assert 10 ** (dbm / 10) / 1000 == pytest.approx(watts, rel=1e-4)


@pytest.mark.parametrize("distance", [1.0, 7.5, 50.0, 163.0, 1000.0, 1e5])
@pytest.mark.parametrize("reference", [1.0, 0.5, 7.0])
def test_path_loss_by_hand(distance, reference):
    expected = 20 - (40.05 + 10 * 2.8 * np.log10(max(distance, reference) / reference))
    assert received_dbm(distance, reference_distance=reference) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("distance", [0.0, 1e-3, 1.0])
def test_nearer_than_the_reference_distance_counts_as_there(distance):
    assert received_dbm(distance) == pytest.approx(20 - 40.05, abs=1e-4)
    assert received_dbm(distance, reference_distance=5.0) == pytest.approx(20 - 40.05, abs=1e-4)


@pytest.mark.parametrize(("walls", "loss"), [(0, 2.0), (1, 2.0), (7, 2.0), (3, 5.0), (4, 0.0)])
def test_each_wall_costs_its_decibels(walls, loss):
    assert received_dbm(80, walls, wall_loss_db=loss) == pytest.approx(received_dbm(80) - walls * loss, abs=1e-4)


@pytest.mark.parametrize(("deviate", "sigma"), [(1.0, 4.0), (-2.5, 4.0), (3.0, 2.8), (1.7, 0.0)])
def test_shadowing_is_sigma_decibels_per_deviate(deviate, sigma):
    shifted = received_dbm(80, shadow=deviate, shadowing_db=sigma)
    assert shifted == pytest.approx(received_dbm(80) + deviate * sigma, abs=1e-4)


def test_half_power_and_levels():
    radio = RadioParameters.of(Radio())
    assert float(radio.half_power) == pytest.approx(0.5, rel=1e-4)
    assert float(radio.noise) == pytest.approx(3.981e-10, rel=1e-3)
    assert float(radio.sensitivity) == pytest.approx(6.3096e-9, rel=1e-3)
    assert float(radio.threshold) == pytest.approx(10, rel=1e-6)
    assert float(RadioParameters.of(Radio(half_power_db=-10.0)).half_power) == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"path_loss_exponent": 3.0},
        {"power_dbm": 10.0},
        {"reference_distance": 10.0},
        {"receive_threshold_dbm": -70.0},
    ],
)
def test_network_range_is_where_the_mean_received_power_equals_the_threshold(settings):
    radio = Radio(**settings)
    assert float(RadioParameters.of(radio).network_range) == pytest.approx(radio.network_range)
    assert received_dbm(radio.network_range, **settings) == pytest.approx(radio.receive_threshold_dbm, abs=1e-3)


def test_the_networks_range_of_the_specification():
    assert Radio().network_range == pytest.approx(163, abs=0.5)


def test_power_falls_with_distance():
    dbm = received_dbm(np.linspace(1, 2000, 500))
    assert (np.diff(dbm) < 0).all()


def received(signal, disturbance=0.0, **settings):
    radio = RadioParameters.of(Radio(**settings))
    return bool(decodable(jnp.float32(signal), jnp.float32(disturbance), radio))


def test_reception_needs_the_threshold_power_and_not_less():
    edge = np.float32(milliwatts(-82))
    assert received(edge)
    assert not received(np.nextafter(edge, np.float32(0)))
    assert received(edge * 2)


def test_reception_needs_the_threshold_ratio():
    """1 nW of noise and interference of 1 nW ask for 20 nW."""
    quiet = {"noise_dbm": -60.0, "receive_threshold_dbm": -120.0}
    assert received(20.001e-6, 1e-6, **quiet)
    assert not received(19.999e-6, 1e-6, **quiet)
    assert received(10.001e-6, 0, **quiet)
    assert not received(9.999e-6, 0, **quiet)
    assert received(2.001e-6, 1e-6, sinr_threshold_db=0.0, **quiet)


def test_a_strong_signal_in_stronger_noise_and_a_clear_one_too_weak_are_both_lost():
    assert not received(1e-3, 1e-3)
    assert not received(1e-9, 0)


def test_interference_that_silences_a_link_at_the_networks_edge():
    """At -82 dBm the threshold of 10 dB leaves room for -92 dBm of noise and interference in all."""
    signal = milliwatts(-81.99)
    room = milliwatts(-92) - milliwatts(-94)
    assert received(signal, 0.99 * room)
    assert not received(signal, 1.02 * room)


def test_shapes_broadcast_over_links_and_batch():
    radio = RadioParameters.of(Radio())
    squared = jnp.ones((3, 4, 5), jnp.float32)
    assert received_power(squared, jnp.float32(0), jnp.zeros((3, 4, 5), jnp.float32), radio).shape == (3, 4, 5)
    assert decodable(squared, jnp.float32(0), radio).shape == (3, 4, 5)


def test_programs_of_one_fading_are_never_taken_for_those_of_another():
    """JAX looks for a compiled program by the structure of its arguments, of which two may not be equal."""
    kinds = ("none", "lognormal", "rayleigh", "rician", "nakagami")
    structures = [jax.tree.structure(RadioParameters.of(Radio(fading=fading))) for fading in kinds]
    assert all(one != other for one, other in itertools.combinations(structures, 2))
    assert structures[1] == jax.tree.structure(RadioParameters.of(Radio(fading="lognormal", shadowing_db=7.0)))
