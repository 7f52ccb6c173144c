"""Every action of the vocabulary resolved against random worlds, and the obstacle that the lidar sees."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely
import shapely.ops

from slcs2_jax.grammar import vocabulary
from slcs2_jax.grammar.vocabulary import MOVE_TARGETS, NO_ACTION, PAPER, SEND_TARGETS
from slcs2_jax.swarm.intent import nearest_obstacle

VERTICAL = [(20, -10, 40), (61, 0, 30)]
HORIZONTAL = [(50, 10, 70)]


def interpret(make, state, links, arena, action, seen=None):
    physics = make.physics()
    seen = make.see(state, links, arena, physics) if seen is None else seen
    actions = jnp.full(len(state.x), action, jnp.int32)
    intent = make.interpret(actions, seen.view, physics.language)
    return jax.tree.map(np.asarray, intent)


def plain_obstacle(view, lidar=10.0):
    """Nearest wall surface or agent within the lidar's range."""
    boxes = [shapely.box(x - 0.5, a, x + 0.5, b) for x, a, b in VERTICAL]
    boxes += [shapely.box(a, y - 0.5, b, y + 0.5) for y, a, b in HORIZONTAL]
    here = shapely.Point(view.here)
    points = [shapely.ops.nearest_points(box, here)[0].coords[0] for box in boxes] + view.others
    nearest = min(points, key=lambda p: math.dist(p, view.here))
    return nearest if math.dist(nearest, view.here) <= lidar else None


def plain_target(view, name, state, arena):
    """Where a move's target is, None if undefined."""
    if name == "jammer":
        return (float(arena.jammer_x), float(arena.jammer_y)) if state.jammer_range[view.me] > 0 else None
    if name == "obstacle":
        return plain_obstacle(view)
    node = view.role(name)
    return None if node is None else view.place[node]


@pytest.fixture(scope="module")
def worlds(make):
    rng = np.random.default_rng(8)
    views = [make.view(rng, size=90.0, vertical=VERTICAL, horizontal=HORIZONTAL) for _ in range(12)]
    return [(view, make.see(*view, make.physics())) for view in views]


@pytest.mark.parametrize("number", range(len(PAPER.actions)))
def test_every_action(make, worlds, number):
    action = PAPER.actions[number]
    known = []
    for (state, links, arena), seen in worlds:
        got = interpret(make, state, links, arena, number, seen)
        assert got.acts.all()
        for field in ("moves", "collects", "sends"):
            assert (getattr(got, field) == (action.kind == field[:-1])).all()
        for i in range(5):
            view = make.plain(state, arena, links.heard, i)
            if action.kind == "move":
                expected = plain_target(view, MOVE_TARGETS[action.target], state, arena)
                assert got.direction[i] == action.direction
                assert got.place_known[i] == (expected is not None)
                if expected is not None:
                    np.testing.assert_allclose((got.place_x[i], got.place_y[i]), expected, atol=1e-4)
                known.append(expected is not None)
                continue
            assert got.channel[i] == action.channel
            assert got.level[i] == pytest.approx(1 if action.power == vocabulary.FULL else 0.5, rel=1e-3)
            if action.kind == "send":
                expected = view.role(SEND_TARGETS[action.target], only_heard=True)
                assert got.node[i] == (7 if expected is None else expected)
                known.append(expected is not None)
    if action.kind != "collect":
        assert any(known)
    if action.kind == "send" or (action.kind == "move" and MOVE_TARGETS[action.target] in ("jammer", "obstacle")):
        assert not all(known)


def test_no_action_is_nothing_at_all(make, worlds):
    got = interpret(make, *worlds[0][0], NO_ACTION)
    for field in ("acts", "moves", "collects", "sends"):
        assert not getattr(got, field).any()


def test_sending_goes_to_those_heard_and_moving_to_those_known(make):
    arena = make.arena([(200, 0), (230, 0), (260, 0)])
    state = make.know(make.state(arena, t=5), {(0, 1): (3, 230, 0), (0, 2): (5, 260, 0)})
    links = make.links(3, heard=[(0, 2)])
    sends = interpret(make, state, links, arena, PAPER.send_action(vocabulary.SI))
    moves = interpret(make, state, links, arena, PAPER.move_action(vocabulary.TOWARD, vocabulary.SI))
    assert sends.node[0] == 2
    assert (moves.place_x[0], moves.place_y[0]) == (230, 0)


@pytest.mark.parametrize(("target", "node"), [(vocabulary.SOURCE, 3), (vocabulary.SINK, 4)])
def test_sending_to_source_or_sink_needs_hearing_it(make, target, node):
    arena = make.arena([(200, 0), (230, 0), (260, 0)])
    for heard, expected in ([(0, node)], node), ([(0, 7 - node), (0, 1)], 5):
        got = interpret(make, make.state(arena), make.links(3, heard=heard), arena, PAPER.send_action(target))
        assert got.node[0] == expected


def test_the_sink_is_moved_to_where_it_is_believed(make):
    arena = make.arena([(200, 0), (230, 0)], estimate=(555, 7))
    got = interpret(make, make.state(arena), make.links(2), arena, PAPER.move_action(0, vocabulary.SINK))
    assert (got.place_x[0], got.place_y[0]) == (555, 7)


def obstacle(make, places, **options):
    arena = make.arena(places, **options)
    found = jax.jit(nearest_obstacle)(make.state(arena), arena, make.physics().swarm)
    return [(float(found.x[i]), float(found.y[i])) for i in range(len(places))], np.sqrt(found.squared)


def test_agents_and_walls_are_obstacles_but_nodes_are_not(make):
    points, distance = obstacle(make, [(3, 0), (9, 0)], jammer=(3, 1))
    assert points == [(9, 0), (3, 0)]
    np.testing.assert_allclose(distance, 6)
    points, distance = obstacle(make, [(3, 0), (9, 0)], vertical=[(0, -5, 5)], horizontal=[(4, 0, 20)])
    assert points == [(0.5, 0), (9, 3.5)]
    np.testing.assert_allclose(distance, [2.5, 3.5])


def test_a_wall_comes_before_an_agent_as_near(make):
    assert obstacle(make, [(0, 0), (0, 4)], vertical=[(4.5, -5, 1)])[0][0] == (4, 0)


@pytest.mark.parametrize(("apart", "seen"), [(9.9, True), (10, True), (10.1, False)])
def test_the_lidar_sees_as_far_as_its_range(make, apart, seen):
    arena = make.arena([(100, 0), (100 + apart, 0)])
    got = interpret(make, make.state(arena), make.links(2), arena, PAPER.move_action(1, vocabulary.OBSTACLE))
    assert got.place_known.tolist() == [seen, seen]
