"""Several jammers in worlds made from a seed, quiet ones, patrols, and a user's maker of worlds."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config import InputError, Jammers, Radio, Settings, World
from slcs2_jax.config.registry import KINDS, register
from slcs2_jax.world.scenario import make_scenario
from slcs2_jax.world.strip import make_strip


def settings(kind="jammed", reach="short", **jammers):
    return Settings(world=World.preset(kind, reach), jammers=Jammers(**jammers))


def test_further_jammers_leave_the_first_where_it_was():
    one, five = make_scenario(settings(), 7), make_scenario(settings(count=5, emission="constant", motion="patrol"), 7)
    assert len(one.jammers) == 1
    assert len(five.jammers) == 5
    np.testing.assert_array_equal(one.jammers[0].place, five.jammers[0].place)
    np.testing.assert_array_equal(one.start, five.start)
    assert len({tuple(jammer.place.tolist()) for jammer in five.jammers}) == 5


def test_the_settings_are_the_jammers():
    made = make_scenario(settings(count=2, emission="random", motion="pursue", power_db=-3.0, speed=1.5, duty=0.2,
                                  dwell=7), 1)  # fmt: skip
    for jammer in made.jammers:
        assert (jammer.emission, jammer.motion, jammer.power_db) == ("random", "pursue", -3.0)
        assert (jammer.speed, jammer.duty, jammer.dwell, len(jammer.route)) == (1.5, 0.2, 7, 0)
        assert not jammer.plain
    assert make_scenario(settings(), 1).jammers[0].plain


def test_there_are_none_where_the_environment_has_none():
    assert make_scenario(settings("urban", count=3), 1).jammers == ()


@pytest.mark.parametrize("points", [2, 5])
def test_a_patrol_keeps_to_where_jammers_may_be(points):
    net = Radio().network_range
    for seed in range(20):
        for jammer in make_scenario(settings(count=2, motion="patrol", patrol_points=points), seed).jammers:
            assert jammer.route.shape == (points - 1, 2)
            assert ((jammer.route[:, 0] > net) & (jammer.route[:, 0] < 600 - net)).all()
            assert (np.abs(jammer.route[:, 1]) <= 100).all()


@pytest.mark.parametrize(
    ("reach", "margin", "power"), [("long", 0.0, 0.0), ("short", 0.0, -10.0), ("short", 6.0, -15.0)]
)
def test_with_a_margin_source_and_sink_hear_nothing_above_the_noise(reach, margin, power):
    radio = Radio()
    for seed in range(30):
        made = make_scenario(settings(reach=reach, margin_db=margin, power_db=power, count=2), seed)
        for jammer in made.jammers:
            for node in ((0.0, 0.0), made.sink):
                distance = np.hypot(*(jammer.place - np.array(node)))
                heard = 20 + power - 40.05 - 28 * np.log10(distance)
                assert heard <= radio.noise_dbm - margin + 1e-3
                assert heard < radio.receive_threshold_dbm
            assert abs(jammer.place[1]) <= 100


@pytest.mark.parametrize(("margin", "said"), [(0.0, {}), (30.0, {"power_db": -10.0})])
def test_a_margin_that_leaves_no_place_is_refused(margin, said):
    with pytest.raises(InputError, match=r"jammers\.margin_db=.*no place.*accepted is a lower jammers\.power_db"):
        make_scenario(settings(margin_db=margin, **said), 0)


@pytest.fixture
def ring():
    """A user's world, registered for the test."""

    def make(settings, seed):
        made = make_strip(settings, seed)
        return dataclasses.replace(made, environment="ring", sink=np.array([0, settings.world.distance], np.float32))

    register("scenario", "ring")(make)
    yield
    KINDS["scenario"].forget("ring")


def test_a_users_maker_is_chosen_by_name(ring):
    said = Settings(world=World(scenario="ring", distance=300.0))
    made = make_scenario(said, 5)
    assert (made.environment, made.seed) == ("ring", 5)
    assert made.sink.tolist() == [0, 300]


def test_a_users_maker_that_makes_none_is_named(ring):
    KINDS["scenario"].add("ring", lambda settings, seed: None, __name__)
    with pytest.raises(InputError, match=r"world\.scenario=ring of .*: scenario=NoneType: accepted is a Scenario"):
        make_scenario(Settings(world=World(scenario="ring")), 0)


def test_a_users_world_is_checked(ring):
    def make(settings, seed):
        return dataclasses.replace(make_strip(settings, seed), sink=np.array([np.nan, 0], np.float32))

    KINDS["scenario"].add("ring", make, __name__)
    with pytest.raises(InputError, match=r"world\.scenario=ring of .*: scenario\.sink=nan: accepted is"):
        make_scenario(Settings(world=World(scenario="ring")), 0)
