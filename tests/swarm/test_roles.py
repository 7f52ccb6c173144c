"""Source-side, sink-side and closest: who they are among those known, and among those heard."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.grammar import vocabulary
from slcs2_jax.swarm import roles
from slcs2_jax.swarm.selection import least, take

ALWAYS = jnp.float32(0)  # a witness

ROLES = ("so", "si", "c")


resolve = jax.jit(roles.resolve)


def distances(make, arena, entries, **fields):
    """d_so, d_si, d_c of agent 0, inf if undefined, and its squared-distance table."""
    state = make.know(make.state(arena, **fields), {(0, j): (1, x, y) for j, (x, y) in entries.items()})
    who = make.candidates(state, arena)
    sides = (who.source_side, who.sink_side, True)
    return [float(roles.closest(who.known & side, who.squared)[0]) for side in sides]


def world(make, x, y, **options):
    return make.arena([(x, y), (-1000, 0), (-1000, 5), (-1000, 9)], **options)


def test_source_and_sink_are_candidates(make):
    """Knowing nobody, the source is source-side and the sink sink-side."""
    so, si, c = distances(make, world(make, 200, 0), {})
    assert (so, si, c) == (200, 400, 200)


def test_the_closest_that_is_nearer_counts(make):
    so, si, c = distances(make, world(make, 200, 0), {1: (150, 0), 2: (230, 0), 3: (190, 0)})
    assert (so, si, c) == (10, 30, 10)


def test_sides_are_by_distance_not_by_direction(make):
    """From (200, 0), (210, 150) is farther than the agent from the source and from the sink as well."""
    so, si, c = distances(make, world(make, 200, 0), {1: (210, 150)})
    assert (so, si) == (200, 400)
    assert c == pytest.approx(np.hypot(10, 150))


def test_one_neighbour_may_be_on_both_sides(make):
    """From (300, 200), (300, 100) is nearer to both."""
    assert distances(make, world(make, 300, 200), {1: (300, 100)}) == [100, 100, 100]


def test_nearer_is_strict(make):
    """Equally far from the source is not source-side; equally far from the sink not sink-side."""
    so, si, _ = distances(make, world(make, 300, 40), {1: (300, -40)})
    assert so == pytest.approx(np.hypot(300, 40))
    assert si == pytest.approx(np.hypot(300, 40))


def test_at_the_source_nobody_is_source_side(make):
    so, si, _ = distances(make, world(make, 0, 0), {1: (3, 4)})
    assert so == np.inf
    assert si == 5


def test_at_the_estimated_sink_nobody_is_sink_side(make):
    so, si, _ = distances(make, world(make, 590, 10, estimate=(590, 10)), {1: (590, 12)})
    assert si == np.inf
    assert so == pytest.approx(np.hypot(590, 10))  # the neighbour is farther from the source


def test_the_sink_stands_where_it_is_believed(make):
    assert distances(make, world(make, 500, 0, estimate=(550, 0)), {})[1] == 50


def test_others_stand_where_they_were_last_known(make):
    """Agent 1 really is at (-1000, 0)."""
    assert distances(make, world(make, 200, 0), {1: (201, 0)})[2] == 1


def test_ties_go_to_the_lowest_index(make):
    arena = world(make, 200, 0)
    state = make.know(make.state(arena), {(0, j): (1, 210, 0) for j in (3, 2)} | {(0, 1): (1, 220, 0)})
    who = make.candidates(state, arena)
    target = jnp.full(4, vocabulary.SI, jnp.int32)
    assert int(resolve(target, who.known, who, ALWAYS)[0]) == 2
    target = jnp.full(4, vocabulary.C, jnp.int32)
    assert int(resolve(target, who.known, who, ALWAYS)[0]) == 2


def test_what_differs_by_rounding_only_is_a_tie(make):
    """Half a millimetre: agents that stop at the clearance from another are all as far, in theory."""
    arena = world(make, 200, 0)
    for nearest, expected in ((209.9995, 2), (209.99, 3)):
        state = make.know(make.state(arena), {(0, 2): (1, 210, 0), (0, 3): (1, nearest, 0)})
        who = make.candidates(state, arena)
        assert int(resolve(jnp.full(4, vocabulary.SI, jnp.int32), who.known, who, ALWAYS)[0]) == expected


@pytest.mark.parametrize(("x", "nearer"), [(199.99, True), (199.9995, False), (200, False), (200.01, False)])
def test_nearer_is_nearer_beyond_rounding(make, x, nearer):
    arena = world(make, 200, 0)
    who = make.candidates(make.know(make.state(arena), {(0, 1): (1, -x, 0)}), arena)
    assert bool(who.source_side[1, 0]) == nearer
    who = make.candidates(make.know(make.state(arena), {(0, 1): (1, 600, x + 200)}), arena)
    assert bool(who.sink_side[1, 0]) == nearer


def test_an_agent_precedes_the_sink_on_ties(make):
    arena = world(make, 500, 0)
    state = make.know(make.state(arena), {(0, 3): (1, 600, 0)})
    who = make.candidates(state, arena)
    assert int(resolve(jnp.full(4, vocabulary.SI, jnp.int32), who.known, who, ALWAYS)[0]) == 3


def test_undefined_targets_are_past_the_last_node(make):
    arena = world(make, 0, 0)
    who = make.candidates(make.state(arena), arena)
    nobody = jnp.zeros((6, 4), bool)
    for target in range(5):
        nodes = resolve(jnp.full(4, target, jnp.int32), nobody, who, ALWAYS)
        np.testing.assert_array_equal(nodes, 6)
    assert int(resolve(jnp.full(4, vocabulary.SO, jnp.int32), who.known, who, ALWAYS)[0]) == 6


@pytest.mark.parametrize("only_heard", [False, True])
def test_roles_of_random_worlds(make, only_heard):
    rng = np.random.default_rng(0)
    found = {name: [] for name in vocabulary.SEND_TARGETS}
    for _ in range(40):
        state, links, arena = make.view(rng)
        who = make.candidates(state, arena)
        members = links.heard if only_heard else who.known
        views = [make.plain(state, arena, links.heard, i) for i in range(5)]
        for number, name in enumerate(vocabulary.SEND_TARGETS):
            nodes = np.asarray(resolve(jnp.full(5, number, jnp.int32), members, who, ALWAYS))
            for i in range(5):
                expected = views[i].role(name, only_heard)
                assert nodes[i] == (7 if expected is None else expected), (name, i)
                found[name].append(expected)
    for name in ROLES:
        assert len(set(found[name])) >= 5, name  # agents, nodes


def test_least_and_take(make):
    score = jnp.array([[3.0, 1.0, 2.0], [1.0, 1.0, 9.0], [1.0, 5.0, 0.0]])
    eligible = jnp.array([[True, True, False], [True, True, False], [True, True, False]])
    index, best = least(eligible, score, ALWAYS)
    np.testing.assert_array_equal(index, [1, 0, 3])
    np.testing.assert_array_equal(best, [1, 1, np.inf])
    np.testing.assert_array_equal(take(score, index), [1, 1, 0])
