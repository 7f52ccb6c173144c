"""Links, jammer and beacons: worked numbers."""

import math

import numpy as np
import pytest

from slcs2_jax.config import Learning, Radio, Swarm
from tests.oracle import inputs, radio
from tests.oracle.randomness import SHADOWING, stream

LOG_PER_DECIBEL = math.log(10) / 10
MAIN = np.array([True, False, False])
ALL = np.array([True, True, True])


def decibel(log_power):
    return log_power / LOG_PER_DECIBEL


@pytest.mark.parametrize(
    ("apart", "dbm"),
    [(0.0, -20.05), (1.0, -20.05), (10.0, -48.05), (100.0, -76.05), (600.0, -20.05 - 28 * math.log10(600))],
)
def test_path_loss(calm, make, apart, dbm):
    case = make.place([(0, 0), (apart, 0)], params=calm)
    power = radio.link_power(0, 1, case.state.place, case.world.vertical, case.world.horizontal, calm, 1, 2)
    assert decibel(power) == pytest.approx(dbm)


def test_network_range_is_where_the_mean_power_is_just_received(params):
    assert params.network_range == pytest.approx(163.1, abs=0.1)


def test_walls_cost_their_loss_each(calm, make):
    walls = {"vertical": [(3, -5, 5), (7, -5, 5), (20, -5, 5)], "horizontal": [(0.5, 4, 6)]}
    case = make.place([(0, 0), (10, 1)], params=calm, **walls)
    through = radio.wall_loss(0, 1, case.state.place, case.world.vertical, case.world.horizontal, calm)
    assert decibel(through) == pytest.approx(3 * 2.0)


def test_shadowing_is_reciprocal_has_its_spread_and_changes_every_step(params, make):
    case = make.place([(0, 0), (10, 0)])
    nothing = case.world.vertical, case.world.horizontal, params

    def power(u, v, t):
        return decibel(radio.link_power(u, v, case.state.place, *nothing, *stream(3, 4, t, SHADOWING)))

    sample = np.array([power(0, 1, t) for t in range(4000)])
    assert power(1, 0, 17) == sample[17]
    assert sample.mean() == pytest.approx(-48.05, abs=0.25)
    assert sample.std() == pytest.approx(4.0, abs=0.15)


def hear(case, channels=MAIN, t=0):
    """Jam and hear; returns whether the jammer is active."""
    world, work, place = case.world, case.work, case.state.place
    active = radio.jam_nodes(place, world, case.params, t, 9, work.jam)
    radio.hear_beacons(place, world, channels, work.jam, case.params, t, 9, work.floor, work.heard)
    return active


def test_beacons_are_heard_within_network_range_only(calm, make):
    case = make.place([(0, 0), (163, 0), (163.5, 0)], params=calm)
    assert not hear(case)
    expected = [[0, 1, 0, 1, 0], [1, 0, 1, 1, 0], [0, 1, 0, 0, 0]]
    np.testing.assert_array_equal(case.work.heard, np.array(expected, bool))


def test_a_wall_silences_a_beacon(calm, make):
    case = make.place([(0, 0), (150, 0)], params=calm, vertical=[(75, -1, 1)])
    hear(case)
    assert not case.work.heard[0, 1]
    assert not case.work.heard[1, 0]


def test_jammer_sleeps_until_a_beacon_reaches_it(calm, make):
    case = make.place([(0, 0), (10, 0)], params=calm, jammer=(300.0, 0.0))
    assert not hear(case)
    assert not case.work.jam.any()
    case = make.place([(0, 0), (150, 0)], params=calm, jammer=(300.0, 0.0))
    assert hear(case)
    assert case.work.jam[1] == pytest.approx(10 ** ((-20.05 - 28 * math.log10(150)) / 10))


def test_jammer_silences_one_channel_only(calm, make):
    case = make.place([(0, 0), (20, 0), (140, 0)], params=calm, jammer=(30.0, 0.0))
    hear(case, MAIN)
    assert not case.work.heard[1, 2]
    assert not case.work.heard[1, 0]
    hear(case, ALL)
    assert case.work.heard[1, 2]
    assert case.work.heard[1, 0]
    v = 1
    assert radio.noise_on(0, v, case.work.jam, ALL, calm) == pytest.approx(calm.noise + case.work.jam[v])
    assert radio.noise_on(1, v, case.work.jam, ALL, calm) == calm.noise


def test_a_beacon_must_be_ten_decibel_above_the_jammer(calm, make):
    # 28 log10(ratio) = 10 dB at a ratio of 2.276 of the distances
    for apart, heard in ((10.0, True), (11.0, False)):
        case = make.place([(0, 0), (apart, 0)], params=calm, jammer=(-24.0, 0.0))
        hear(case)
        assert case.work.heard[0, 1] == heard


def test_jammer_range_is_the_greatest_distance_of_reception(calm, make):
    case = make.place([(0, 0), (100, 0)], params=calm, jammer=(150.0, 0.0))
    known = np.array([160.0, 0.0])
    assert hear(case)
    radio.notice_jammer(case.state.place, calm, True, case.work.jam, known)
    np.testing.assert_allclose(known, [160.0, 50.0])
    far = make.place([(-50, 0), (100, 0)], params=calm, jammer=(150.0, 0.0))
    known = np.zeros(2)
    hear(far)
    radio.notice_jammer(far.state.place, calm, True, far.work.jam, known)
    np.testing.assert_allclose(known, [0.0, 50.0])


def test_no_link_is_lost_by_the_shortcut_for_far_pairs(make):
    near = inputs.make_params(Radio(), Swarm(), Learning())
    patient = near._replace(square_range=1e12)
    rng = np.random.default_rng(1)
    for t in range(40):
        start = rng.uniform(-700, 700, (12, 2))
        one, other = make.place(start, params=near), make.place(start, params=patient)
        hear(one, t=t)
        hear(other, t=t)
        np.testing.assert_array_equal(one.work.heard, other.work.heard)
