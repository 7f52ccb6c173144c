"""Jammers stacked for the device: what room they need, who fits, and whose answer counts."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import Settings
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.emission import Listening
from slcs2_jax.world.emitters import JammerRoom, has_room, jammer_room, moved, stack_emitters, transmits_on
from slcs2_jax.world.jammer_motion import Wandering
from slcs2_jax.world.scenario import Jammer, make_scenario


def place(x, y):
    return np.array([x, y], np.float32)


def world(*jammers):
    return dataclasses.replace(make_scenario(Settings(), 0), jammers=jammers)


PLAIN = Jammer(place(300, 0))
SWEEPER = Jammer(place(200, 5), emission="sweeping", motion="patrol", route=np.array([[210, 5], [220, 5]], np.float32),
                 speed=3.0, dwell=4, power_db=3.0)  # fmt: skip
HUNTER = Jammer(place(100, 9), emission="constant", motion="pursue", duty=0.25)


def test_the_papers_worlds_need_no_room():
    assert jammer_room([world(), world(PLAIN)]) is None
    assert jammer_room([]) is None
    assert stack([world(PLAIN)], [(0,)], capacity=(0, 0), width=1).emitters is None


def test_the_room_is_for_all_of_them():
    room = jammer_room([world(PLAIN), world(SWEEPER, HUNTER), world()])
    assert room == JammerRoom(2, 3, ("constant", "reactive", "sweeping"), ("fixed", "patrol", "pursue"))
    assert jammer_room([world(PLAIN, PLAIN)]) == JammerRoom(2, 1, ("reactive",), ("fixed",))
    assert jammer_room([world(dataclasses.replace(PLAIN, power_db=-3.0))]) is not None


@pytest.mark.parametrize(
    ("room", "jammers", "fits"),
    [
        (None, (), True),
        (None, (PLAIN,), True),
        (None, (PLAIN, PLAIN), False),
        (JammerRoom(1, 1, ("sweeping",), ("patrol",)), (), True),
        (JammerRoom(1, 1, ("sweeping",), ("patrol",)), (PLAIN,), False),
        (JammerRoom(1, 3, ("sweeping",), ("patrol",)), (SWEEPER,), True),
        (JammerRoom(1, 2, ("sweeping",), ("patrol",)), (SWEEPER,), False),
        (JammerRoom(1, 3, ("constant",), ("patrol",)), (SWEEPER,), False),
        (JammerRoom(1, 3, ("sweeping",), ("patrol",)), (SWEEPER, SWEEPER), False),
    ],
)
def test_who_fits(room, jammers, fits):
    assert has_room(room, world(*jammers)) == fits


def test_everything_stands_in_its_column():
    scenarios = [world(SWEEPER, HUNTER), world(), world(PLAIN)]
    room = jammer_room(scenarios)
    made = stack_emitters(scenarios, room)
    assert made.exists.T.tolist() == [[True, True], [False, False], [True, False]]
    assert made.route_x[:, 0, 0].tolist() == [200, 210, 220]
    assert made.route_x[:, 1, 0].tolist() == [100] * 3
    assert (made.route_x[:, 0, 1] > 5e4).all()
    assert [room.emissions[k] for k in made.emission[:, 0]] == ["sweeping", "constant"]
    assert [room.motions[k] for k in made.motion[:, 0]] == ["patrol", "pursue"]
    np.testing.assert_allclose(made.level[:, 0], [10**0.3, 1], rtol=1e-6)
    assert made.speed[0, 0] == 3
    assert made.dwell[0, 0] == 4
    assert made.duty[1, 0] == 0.25
    arena = stack(scenarios, [(0,)] * 3, capacity=wall_capacity(scenarios), width=1)
    assert arena.has_jammer.tolist() == [True, False, True]
    assert arena.jammer_x[0] == 200


def test_each_answers_as_its_own_kind_and_none_where_there_is_none():
    scenarios = [world(SWEEPER, HUNTER), world(PLAIN)]
    emitters = stack_emitters(scenarios, jammer_room(scenarios))
    both = jnp.array([[1, 1], [1, 1]], bool)
    listening = Listening(
        t=jnp.array([4, 4], jnp.int32),
        number=np.array([[0], [1]], np.int32),
        hears=both,
        channels=jnp.array([[True, True], [True, True], [True, True]]),
        duty=emitters.duty,
        dwell=emitters.dwell,
        words=None,
    )
    assert transmits_on(emitters, listening).T.tolist() == [[1, 0], [0, -1]]
    here = jnp.zeros((2, 2), jnp.float32)
    x, y = moved(
        emitters,
        Wandering(
            t=jnp.array([0, 0], jnp.int32),
            x=emitters.route_x[0],
            y=emitters.route_y[0],
            route_x=jnp.asarray(emitters.route_x),
            route_y=jnp.asarray(emitters.route_y),
            speed=emitters.speed,
            hears=both,
            heard_x=here,
            heard_y=here + 9,
        ),
    )
    np.testing.assert_allclose(x[:, 0], [203, 98])
    np.testing.assert_allclose(y[:, 0], [5, 9])
    assert x[0, 1] == 300
