"""How jammers move: a patrol against Shapely's walk along the closed way, a pursuit by hand."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from slcs2_jax.world import jammer_motion
from slcs2_jax.world.jammer_motion import Wandering


def wandering(t=0, *, at=(0.0, 0.0), route=((0.0, 0.0),), speed=2.0, hears=True, heard=(0.0, 0.0)):
    """One jammer."""
    route = np.array(route, np.float32)[:, None]
    place, strongest = np.array(at, np.float32)[:, None], np.array(heard, np.float32)[:, None]
    return Wandering(
        t=jnp.int32(t),
        x=jnp.asarray(place[0]),
        y=jnp.asarray(place[1]),
        route_x=jnp.asarray(route[..., 0]),
        route_y=jnp.asarray(route[..., 1]),
        speed=jnp.full(1, speed, jnp.float32),
        hears=jnp.array([hears]),
        heard_x=jnp.asarray(strongest[0]),
        heard_y=jnp.asarray(strongest[1]),
    )


def place(found):
    return float(found[0][0]), float(found[1][0])


def test_a_fixed_one_stays():
    assert place(jammer_motion.fixed(wandering(at=(3, 4)))) == (3, 4)


@pytest.mark.parametrize(
    "route", [[(0, 0), (30, 40)], [(10, 0), (10, 25), (-40, 25), (0, -7)], [(5, 5), (5, 5), (9, 5), (5, 5)]]
)
@pytest.mark.parametrize("speed", [0.7, 2.0, 60.0])
def test_a_patrol_is_at_its_distance_along_the_closed_way(route, speed):
    way = shapely.LineString([*route, route[0]])
    for t in (0, 1, 7, 50, 999):
        expected = way.interpolate((t + 1) * speed % way.length)
        found = place(jammer_motion.patrol(wandering(t, route=route, speed=speed)))
        assert found == pytest.approx((expected.x, expected.y), abs=0.01)


def test_a_patrol_of_one_point_stays_there():
    assert place(jammer_motion.patrol(wandering(17, route=[(8, 9)]))) == (8, 9)
    assert place(jammer_motion.patrol(wandering(17, route=[(8, 9), (8, 9)]))) == (8, 9)


@pytest.mark.parametrize(
    ("heard", "hears", "expected"),
    [
        ((30.0, 40.0), True, (1.2, 1.6)),  # a step of 2 m along (3, 4) / 5
        ((0.6, 0.8), True, (0.6, 0.8)),  # no farther than there
        ((0.0, 0.0), True, (0.0, 0.0)),
        ((30.0, 40.0), False, (0.0, 0.0)),
    ],
)
def test_a_pursuer_steps_toward_the_strongest(heard, hears, expected):
    found = place(jammer_motion.pursue(wandering(heard=heard, hears=hears)))
    assert found == pytest.approx(expected, abs=1e-6)
