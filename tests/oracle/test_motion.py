"""Kinds of moves, clearance and the slide along obstacles: worked cases."""

import math

import numpy as np
import pytest

from slcs2_jax.grammar import vocabulary
from slcs2_jax.grammar.vocabulary import PAPER
from tests.oracle import motion
from tests.oracle.words import NO_ACTION

TOWARD, AWAY, ORBIT = vocabulary.TOWARD, vocabulary.AWAY, vocabulary.ORBIT
SO, SI, C, SOURCE, SINK, JAMMER, OBSTACLE = range(7)


@pytest.mark.parametrize(
    ("direction", "target", "expected"),
    [
        (TOWARD, (10, 0), (2, 0)),
        (TOWARD, (3, 0), (1, 0)),  # stops at the clearance
        (TOWARD, (1.5, 0), (0, 0)),
        (TOWARD, (0, 0), (0, 0)),
        (TOWARD, (-30, 40), (-1.2, 1.6)),
        (AWAY, (10, 0), (-2, 0)),
        (AWAY, (0, 0), (0, 0)),
        (ORBIT, (0, 0), (0, 0)),
        (ORBIT, (1, 0), (2, 0)),  # half a turn: the chord is the diameter
        (ORBIT, (0.5, 0), (1, 0)),  # and never longer than it
        (ORBIT, (2, 0), (1, -math.sqrt(3))),  # a sixth of a turn, counter-clockwise: below the target
    ],
)
def test_displacement(params, direction, target, expected):
    assert motion.displacement(direction, *map(float, target), params) == pytest.approx(expected, abs=1e-12)


def test_orbit_keeps_the_radius(params):
    x, y = 7.0, 0.0
    turned = 0.0
    for _ in range(200):
        sx, sy = motion.displacement(ORBIT, -x, -y, params)
        assert math.hypot(sx, sy) == pytest.approx(params.speed)
        angle = math.atan2(y + sy, x + sx) - math.atan2(y, x)
        turned += angle % (2 * math.pi)
        x, y = x + sx, y + sy
    assert math.hypot(x, y) == pytest.approx(7.0)
    assert turned == pytest.approx(200 * 2 * math.asin(1 / 7))


def move(case, *actions):
    """Where the agents end."""
    case.work.action[:] = actions
    motion.propose(case.state, case.world, case.params, case.work)
    motion.resolve(case.state, case.world, case.params, case.work)
    return case.work.moved


def act(direction, target):
    return PAPER.move_action(direction, target)


STAY = NO_ACTION


@pytest.mark.parametrize(
    ("target", "end"),
    [
        (SO, (10, 0)),
        (SI, (12, 0)),
        (C, (10, 0)),
        (SOURCE, (8, 0)),
        (SINK, (10, 2)),
        (JAMMER, (8, 0)),
        (OBSTACLE, (12, 0)),
    ],
)
def test_targets(make, target, end):
    case = make.place([(10, 0), (16, 0)], sink_estimate=(10.0, 300.0), jammer=(-40, 0))
    case.work.role[0] = (-1, 1, -1)
    case.state.known_place[0, 1] = (20, 0)
    case.state.jammer_range[0] = 50
    np.testing.assert_allclose(move(case, act(TOWARD, target), STAY)[0], end)


def test_unknown_jammer_and_no_obstacle_are_no_targets(make):
    case = make.place([(10, 0), (30, 0)], jammer=(-40, 0))
    np.testing.assert_array_equal(move(case, act(AWAY, JAMMER), act(AWAY, OBSTACLE)), [(10, 0), (30, 0)])


def test_an_agent_stops_before_a_wall_and_slides_along_it(make):
    case = make.place([(7, 0), (0, 90)], vertical=[(10, -50, 50)], sink=(600, 0))
    # 2.5 m from the surface: half a metre is left, two are wanted straight ahead, so the slide goes nowhere
    np.testing.assert_array_equal(move(case, act(TOWARD, SINK), STAY)[0], (7, 0))
    case = make.place([(7, 0), (0, 90)], vertical=[(10, -50, 50)], sink=(107, 100))
    np.testing.assert_allclose(move(case, act(TOWARD, SINK), STAY)[0], (7, math.sqrt(2)))
    case = make.place([(7, 0), (0, 90)], vertical=[(10, -50, 50)], horizontal=[(3.5, 0, 10)], sink=(107, 100))
    np.testing.assert_array_equal(move(case, act(TOWARD, SINK), STAY)[0], (7, 0))  # the slide is blocked as well


def test_an_agent_nearer_than_the_clearance_may_not_come_nearer_but_may_leave(make):
    case = make.place([(8.5, 0), (0, 90)], vertical=[(10, -50, 50)], sink=(600, 0))
    np.testing.assert_array_equal(move(case, act(TOWARD, SINK), STAY)[0], (8.5, 0))
    np.testing.assert_array_equal(move(case, act(AWAY, SINK), STAY)[0], (6.5, 0))
    case = make.place([(8.5, 0), (0, 90)], vertical=[(10, -50, 50)], sink=(8.5, 600))
    np.testing.assert_array_equal(move(case, act(TOWARD, SINK), STAY)[0], (8.5, 2))


def test_a_fast_agent_does_not_jump_over_a_wall(make, params):
    fast = params._replace(speed=8.0, clearance=1.0)
    case = make.place([(7, 0), (0, 90)], vertical=[(10, -50, 50)], sink=(600, 0), params=fast)
    np.testing.assert_array_equal(move(case, act(TOWARD, SINK), STAY)[0], (7, 0))


def test_two_agents_do_not_meet(make):
    case = make.place([(0, 0), (5, 0)], sink=(600, 0))
    # 5 m apart; proposals at 2 and 3 are too near to each other, and the obstacle is straight ahead
    end = move(case, act(TOWARD, SINK), act(TOWARD, SOURCE))
    np.testing.assert_array_equal(end, [(0, 0), (5, 0)])


def test_an_agent_slides_around_another(make):
    case = make.place([(0, 0), (2.5, 0)], sink=(100, 100))
    end = move(case, act(TOWARD, SINK), STAY)
    np.testing.assert_allclose(end[0], (0, math.sqrt(2)), atol=1e-12)


def test_followers_are_held_by_the_present_place_of_the_one_ahead(make):
    case = make.place([(0, 0), (3, 0)], sink=(600, 0))
    end = move(case, act(TOWARD, SINK), act(TOWARD, SINK))
    np.testing.assert_array_equal(end, [(0, 0), (5, 0)])


def test_two_slides_into_one_place_are_both_refused(make):
    # both are refused by a wall each and would slide towards each other
    walls = {"vertical": [(3, -1, 1)]}
    case = make.place([(0.4, -2.0), (0.4, 2.5)], sink=(600, 0), params=None, **walls)
    work = case.work
    work.slides[:] = True
    work.tangent[:] = [(0.4, -0.2), (0.4, 0.5)]
    assert motion.meets_slide(0, case.state.place, work.tangent, work.slides, case.params)
    work.slides[1] = False
    assert not motion.meets_slide(0, case.state.place, work.tangent, work.slides, case.params)


def test_coincident_obstacle_has_no_tangent(make, params):
    case = make.place([(0, 0), (1, 0)], vertical=[(0.2, -5, 5)], sink=(600, 0))
    move(case, act(TOWARD, SINK), STAY)  # inside a wall: distance 0, so no direction to slide along
    assert not case.work.slides[0]
    np.testing.assert_array_equal(case.work.moved[0], (0, 0))
