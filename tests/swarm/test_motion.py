"""Toward, away, orbit; sliding along walls and around agents; and the clearance that nobody breaks."""

from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from slcs2_jax.grammar.vocabulary import AWAY, ORBIT, TOWARD
from slcs2_jax.swarm import motion

ROUNDING = 1.2e-3  # m: a millimetre short of the clearance still meets it, and places are in single precision


def proposed(make, places, moves, **swarm):
    state = make.state(make.arena(places))
    intent = make.intent(len(places), moves=moves)
    step = make.proposed_step(state, intent, make.physics(**swarm).swarm)
    return np.stack(step, axis=-1)


def resolved(make, places, steps, physics=None, **walls):
    """Where everybody is after the proposed steps {agent: (dx, dy)}."""
    arena = make.arena(places, **walls)
    step = np.zeros((2, len(places)), np.float32)
    for i, d in steps.items():
        step[:, i] = d
    physics = physics or make.physics()
    return np.stack(make.resolve(make.state(arena), *jnp.asarray(step), arena, physics.swarm), axis=-1)


AWAY_FROM_ALL = (500.0, 500.0)


@pytest.mark.parametrize(
    ("distance", "expected"), [(100, 2), (5, 2), (4, 2), (3.5, 1.5), (2.25, 0.25), (2, 0), (1.5, 0), (0.1, 0)]
)
def test_toward_makes_a_whole_step_and_stops_at_the_clearance(make, distance, expected):
    step = proposed(make, [(10, 10), AWAY_FROM_ALL], {0: (TOWARD, 10 + 0.6 * distance, 10 + 0.8 * distance)})
    np.testing.assert_allclose(step[0], [0.6 * expected, 0.8 * expected], atol=1e-5)


@pytest.mark.parametrize("distance", [0.01, 1, 3, 1000])
def test_away_is_a_whole_step_the_other_way(make, distance):
    step = proposed(make, [(10, 10), AWAY_FROM_ALL], {0: (AWAY, 10 + 0.6 * distance, 10 + 0.8 * distance)})
    np.testing.assert_allclose(step[0], [-1.2, -1.6], atol=1e-4)


@pytest.mark.parametrize("radius", [0.5, 1.0, 1.2, 2.0, 3.0, 17.0, 400.0])
@pytest.mark.parametrize("speed", [2.0, 0.5])
def test_orbit_keeps_the_radius_and_goes_counter_clockwise(make, radius, speed):
    centre = np.array([3.0, -2.0])
    for angle in (0.1, 1.7, 3.2, 5.5):
        start = centre + radius * np.array([np.cos(angle), np.sin(angle)])
        step = proposed(make, [start, AWAY_FROM_ALL], {0: (ORBIT, *centre)}, speed=speed)[0]
        end = start + step
        assert np.hypot(*(end - centre)) == pytest.approx(radius, rel=2e-5, abs=2e-4)
        assert np.hypot(*step) == pytest.approx(min(speed, 2 * radius), rel=2e-3, abs=1e-4)
        turned = math.remainder(math.atan2(*(end - centre)[::-1]) - angle, 2 * math.pi)
        half = 2 * math.asin(min(1, speed / (2 * radius)))
        assert turned % (2 * math.pi) == pytest.approx(half, rel=1e-3, abs=1e-3)


def test_a_whole_orbit_returns_and_keeps_its_radius(make):
    place = np.array([13.0, 0.0])
    turned = 0.0
    for _ in range(60):
        step = proposed(make, [place, AWAY_FROM_ALL], {0: (ORBIT, 0, 0)})[0]
        turned += math.remainder(math.atan2(*(place + step)[::-1]) - math.atan2(*place[::-1]), 2 * math.pi)
        place = place + step
    assert np.hypot(*place) == pytest.approx(13, rel=1e-4)
    assert turned == pytest.approx(60 * 2 * math.asin(1 / 13), rel=1e-3)


@pytest.mark.parametrize("direction", [TOWARD, AWAY, ORBIT])
def test_no_target_or_being_there_is_no_step(make, direction):
    places = [(10, 10), (20, 20), AWAY_FROM_ALL]
    step = proposed(make, places, {0: (direction, None, None), 1: (direction, 20, 20)})
    assert (step == 0).all()


def test_who_does_not_move_stays(make):
    places = [(10, 10), (20, 20)]
    state = make.state(make.arena(places))
    intent = make.intent(2, sends={0: (1, 0, 1.0)})
    assert (np.stack(make.proposed_step(state, intent, make.physics().swarm)) == 0).all()
    np.testing.assert_array_equal(resolved(make, places, {}), places)


def test_free_agents_take_their_steps_all_at_once(make):
    """1 follows into the room that 0 leaves only as far as 0's place allows."""
    end = resolved(make, [(10, 0), (5, 0)], {0: (2, 0), 1: (1, 0)})
    np.testing.assert_allclose(end, [(12, 0), (6, 0)])
    end = resolved(make, [(10, 0), (7.5, 0)], {0: (2, 0), 1: (1, 0)})
    np.testing.assert_allclose(end, [(12, 0), (7.5, 0)])  # within 2 m of where 0 was; the tangent leads nowhere


def test_two_that_would_meet_both_stay(make):
    end = resolved(make, [(0, 0), (5, 0)], {0: (2, 0), 1: (-2, 0)})
    np.testing.assert_allclose(end, [(0, 0), (5, 0)])


def test_sliding_around_an_agent(make):
    """The one in the way stands at (2.5, 0): the tangent is the y axis."""
    end = resolved(make, [(0, 0), (2.5, 0)], {0: (1.6, 1.2)})
    np.testing.assert_allclose(end[0], (0, 1.2), atol=1e-6)


def test_sliding_along_a_wall(make):
    """A wall 2.5 m ahead, its surface at x = 2.5."""
    end = resolved(make, [(0, 0), AWAY_FROM_ALL], {0: (1.2, 1.6)}, vertical=[(3, -50, 50)])
    np.testing.assert_allclose(end[0], (0, 1.6), atol=1e-6)
    end = resolved(make, [(0, 0), AWAY_FROM_ALL], {0: (-1.6, -1.2)}, horizontal=[(-3, -50, 50)])
    np.testing.assert_allclose(end[0], (-1.6, 0), atol=1e-6)


def test_a_step_that_keeps_the_clearance_of_a_wall_is_free(make):
    end = resolved(make, [(0, 0), AWAY_FROM_ALL], {0: (0.4, 1.6)}, vertical=[(3, -50, 50)])
    np.testing.assert_allclose(end[0], (0.4, 1.6), atol=1e-6)


def test_in_a_corner_an_agent_stays(make):
    walls = {"vertical": [(2.6, -50, 50)], "horizontal": [(2.6, -50, 50)]}
    end = resolved(make, [(0, 0), AWAY_FROM_ALL], {0: (1.4, 1.4)}, **walls)
    np.testing.assert_allclose(end[0], (0, 0))


def test_the_nearest_of_the_obstacles_in_the_way_gives_the_tangent(make):
    """A wall 1 m away at the left, nearer than the agent ahead, forbids nothing and gives no tangent."""
    end = resolved(make, [(0, 0), (2.5, 0)], {0: (1.6, 1.2)}, vertical=[(-1.5, -50, 50)])
    np.testing.assert_allclose(end[0], (0, 1.2), atol=1e-6)
    # Two agents ahead, both in the way: the nearer one, at (0, 2.1), makes the tangent the x axis.
    end = resolved(make, [(0, 0), (3.2, 3.2), (0, 2.1)], {0: (1.4, 1.4)})
    np.testing.assert_allclose(end[0], (1.4, 0), atol=1e-6)


def test_an_agent_too_near_already_may_leave_and_stay_but_not_come_nearer(make):
    near = [(0, 0), (1, 0)]
    np.testing.assert_allclose(resolved(make, near, {0: (-2, 0)})[0], (-2, 0))
    np.testing.assert_allclose(resolved(make, near, {})[0], (0, 0))
    np.testing.assert_allclose(resolved(make, near, {0: (0.5, 0)})[0], (0, 0))
    np.testing.assert_allclose(resolved(make, near, {0: (0, 1)})[0], (0, 1))


def test_nobody_steps_through_a_wall(make):
    """With a clearance smaller than a step the far side would be clear."""
    physics = make.physics(clearance=0.25, speed=2.0)
    end = resolved(make, [(0, 0), AWAY_FROM_ALL], {0: (2, 0)}, physics, vertical=[(1, -5, 5)])
    np.testing.assert_allclose(end[0], (0, 0))


def test_two_that_slide_into_each_other_do_not(make):
    """Both are refused by the wall and slide along it toward each other."""
    places = [(0, -2.4), (0, 2.4)]
    end = resolved(make, places, {0: (1.2, 1.6), 1: (1.2, -1.6)}, vertical=[(3, -50, 50)])
    np.testing.assert_allclose(end, places)
    end = resolved(make, places, {0: (1.2, -1.6), 1: (1.2, 1.6)}, vertical=[(3, -50, 50)])
    np.testing.assert_allclose(end, [(0, -4), (0, 4)], atol=1e-6)


def rectangles(vertical, horizontal):
    return np.array(
        [shapely.box(x - 0.5, a, x + 0.5, b) for x, a, b in vertical]
        + [shapely.box(a, y - 0.5, b, y + 0.5) for y, a, b in horizontal]
    )


@jax.jit
def walk(state, steps, arena, parameters):
    """Everybody's places after each of the steps [count, 2, n]."""

    def body(state, step):
        x, y = motion.resolve(state, step[0], step[1], arena, parameters)
        moved = dataclasses.replace(state, node_x=state.node_x.at[:-3].set(x), node_y=state.node_y.at[:-3].set(y))
        return moved, jnp.stack([x, y])

    return jax.lax.scan(body, state, steps)[1]


@pytest.mark.parametrize(("speed", "clearance"), [(2.0, 2.0), (3.0, 0.4), (0.5, 2.0)])
def test_nobody_ever_overlaps_or_crosses_a_wall_in_a_crowd(make, speed, clearance):
    """16 agents pushed about at random, with a common drift, in a walled yard of 30 m: 400 steps."""
    rng = np.random.default_rng(0)
    vertical = [(-15, -15, 15), (15, -15, 15), (0, -8, 3), (6, 5, 15)]
    horizontal = [(-15, -15, 15), (15, -15, 15), (4, -12, -2), (-6, 3, 12)]
    grid = [(x, y) for x in (-11, -7.5, -4, 3.5, 10) for y in (-11, -7.9, 0.5, 8.5)][:16]
    arena = make.arena(grid, vertical=vertical, horizontal=horizontal)
    parameters = make.physics(speed=speed, clearance=clearance).swarm
    angle = rng.uniform(0, 2 * np.pi, (400, 1)) + rng.normal(0, 0.7, (400, 16))
    lengths = speed * (rng.random((400, 1, 16)) < 0.9)
    steps = (lengths * np.stack([np.cos(angle), np.sin(angle)], axis=1)).astype(np.float32)

    ends = walk(make.state(arena), jnp.asarray(steps), arena, parameters)
    track = np.concatenate([np.array(grid).T[None], np.asarray(ends, np.float64)])  # [401, 2, 16]
    pair = ~np.eye(16, dtype=bool)
    apart = np.hypot(*(track[:, :, :, None] - track[:, :, None]).transpose(1, 0, 2, 3))
    assert (apart >= np.minimum(clearance, apart[:1]) - ROUNDING)[:, pair].all()
    points = shapely.points(track[:, 0], track[:, 1])
    clear = shapely.distance(points[..., None], rectangles(vertical, horizontal))
    assert (clear >= np.minimum(clearance, clear[:1]) - ROUNDING).all()
    centres = [shapely.LineString([(x, a), (x, b)]) for x, a, b in vertical]
    centres += [shapely.LineString([(a, y), (b, y)]) for y, a, b in horizontal]
    paths = shapely.linestrings(np.stack([track[:-1], track[1:]], axis=-1).transpose(0, 2, 3, 1))
    assert not shapely.intersects(paths[..., None], np.array(centres)).any()
    lengths = np.hypot(*np.diff(track, axis=0).transpose(1, 0, 2))
    assert lengths.max() <= speed * 1.0001
    full = np.isclose(lengths, speed, rtol=1e-3)
    assert 0.05 < full.mean() < 0.95  # some are free, some hindered,
    assert ((lengths > 1e-3) & (lengths < 0.99 * speed)).mean() > 0.02  # and some slide
