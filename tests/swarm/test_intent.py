"""Every action of the vocabulary resolved against random worlds, the obstacle that the lidar sees, and users' parts."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely
import shapely.ops

from slcs2_jax.config import InputError
from slcs2_jax.grammar import parse_grammar, vocabulary
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import MOVE_TARGETS, NO_ACTION, PAPER, SEND_TARGETS, Vocabulary
from slcs2_jax.swarm import intent as intents
from slcs2_jax.swarm.intent import nearest_obstacle
from tests.builders import registered

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


NEW = len(PAPER.actions)  # the number of the first action that a user brings
ROUND_IT = "<R> ::= packet held => <A>\n<A> ::= move toward den | move away from den | orbit den"
DO_IT = "<R> ::= packet held => act up"


def own(make, action, text, parts):
    """Everybody's intent in a small world where agents take these actions, of a grammar over a user's parts."""
    arena = make.arena([(30, 0), (80, 0), (120, 0)])
    view = make.look(make.state(arena), make.links(3), arena, make.physics())
    with registered(parts):
        language = Language.of([parse_grammar(text, vocabulary=Vocabulary.current())])
    return intents.interpret(jnp.array(action, jnp.int32), view, language)


def test_an_own_target_is_moved_toward_away_from_and_around(make):
    asked = []

    def den(view):
        asked.append(view)
        return view.x + 5, jnp.float32(-7), view.x > 50

    got = own(make, [NEW + 2, NEW, NEW + 1], ROUND_IT, {"move target": {"den": den}})
    assert got.acts.all()
    assert got.moves.all()
    assert not (got.sends | got.collects).any()
    assert got.direction.tolist() == [vocabulary.ORBIT, vocabulary.TOWARD, vocabulary.AWAY]
    assert got.place_known.tolist() == [False, True, True]
    assert (got.place_x.tolist(), got.place_y.tolist()) == ([35, 85, 125], [-7] * 3)
    assert len(asked) == 1


def test_a_part_that_no_rule_can_say_is_not_computed(make):
    asked = []
    own(make, [0] * 3, "<R> ::= packet held => send to si", {"move target": {"den": asked.append}})
    own(make, [0] * 3, "<R> ::= packet held => send to si", {"action": {"act up": asked.append}})
    assert not asked


@pytest.mark.parametrize(
    ("part", "kind", "fields"),
    [
        (
            lambda view: intents.move(view, view.x, 4.0, known=view.x < 50, direction=vocabulary.AWAY),
            "moves",
            {"place_x": 30, "place_y": 4, "place_known": True, "direction": vocabulary.AWAY, "node": 5},
        ),
        (lambda view: intents.move(view, 1.0, 2.0), "moves", {"direction": vocabulary.TOWARD, "place_known": True}),
        (lambda view: intents.collect(view, channel=2, level=0.25), "collects", {"channel": 2, "level": 0.25}),
        (
            lambda view: intents.send(view, jnp.argmax(view.x).astype(jnp.int32), channel=1),
            "sends",
            {"node": 2, "channel": 1, "level": 1.0},
        ),
    ],
)
def test_an_own_action_moves_collects_or_sends_and_the_others_do_as_ever(make, part, kind, fields):
    others = [PAPER.send_action(vocabulary.SINK, 2, vocabulary.HALF), NO_ACTION]
    got = own(make, [NEW, *others], DO_IT, {"action": {"act up": part}})
    for name in ("moves", "collects", "sends"):
        assert bool(getattr(got, name)[0]) == (name == kind)
    for name, expected in fields.items():
        assert getattr(got, name)[0] == expected, name
    assert got.acts.tolist() == [True, True, False]
    plain = own(make, [NO_ACTION, *others], "<R> ::= packet held => send to si", {})
    for one, other in zip(jax.tree.leaves(got), jax.tree.leaves(plain), strict=True):
        np.testing.assert_array_equal(one[1:], other[1:])
        assert one.dtype == other.dtype


@pytest.mark.parametrize(
    ("kind", "text", "part", "told"),
    [
        ("action", DO_IT, lambda view: None, "returned NoneType; accepted is move, collect or send"),
        ("action", DO_IT, lambda view: view.x, "accepted is move, collect or send"),
        ("move target", ROUND_IT, lambda view: view.x, "accepted are x, y and whether it is known"),
        ("move target", ROUND_IT, lambda view: (view.x, view.y), "returned tuple; accepted are x, y and whether"),
        (
            "move target",
            ROUND_IT,
            lambda view: (view.x, view.y, view.x),
            r"returned float32\[3\]; accepted is bool\[3\]",
        ),
        (
            "move target",
            ROUND_IT,
            lambda view: (view.x, view.state.node_y, view.holding),
            r"returned float32\[6\]; accepted is float32\[3\]",
        ),
        (
            "move target",
            ROUND_IT,
            lambda view: (view.arena.time_limit, view.y, view.holding),
            r"returned int32\[\]; accepted is float32\[3\]",
        ),
    ],
)
def test_a_wrong_part_is_named_in_one_line(make, kind, text, part, told):
    name = "den" if kind == "move target" else "act up"
    with pytest.raises(InputError, match=rf"^{kind} '{name}': .*{told}") as found:
        own(make, [NEW] * 3, text, {kind: {name: part}})
    assert "\n" not in str(found.value)


@pytest.mark.parametrize(
    "part", [lambda view: intents.send(view, jnp.zeros(7)), lambda view: intents.move(view, jnp.zeros((3, 3)), 0.0)]
)
def test_an_own_action_for_another_number_of_agents_is_named_in_one_line(make, part):
    with pytest.raises(InputError, match=r"^action 'act up': ") as found:
        own(make, [NEW] * 3, DO_IT, {"action": {"act up": part}})
    assert "\n" not in str(found.value)
