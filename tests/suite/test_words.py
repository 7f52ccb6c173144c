"""What hand-made entries say: clauses, targets and sends on a drawn moment, and that no oracle is asked."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.grammar.language import Language
from slcs2_jax.suite import words
from slcs2_jax.suite.worlds import load_suite
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import stack

AGENTS = 4


@pytest.fixture(scope="module")
def view():
    """Four agents on the line at 0, 60, 120 and 400 m that know each other; nobody has moved."""
    world = load_suite().worlds["few"]
    settings, scenario = world.settings(5_180_000), world.scenario(5_180_000)
    start = np.array([[1, 3], [60, 0], [120, 0], [400, 0]], np.float32)
    settings = dataclasses.replace(settings, radio=dataclasses.replace(settings.radio, fading="none"))
    physics = Physics.of(settings, Language.whole(words.VOCABULARY))
    moved = dataclasses.replace(scenario, start=start)
    stacked = stack([moved], [(0,)], capacity=(0, 0), width=1)
    arena = jax.tree.map(lambda leaf: jnp.asarray(leaf)[..., 0], stacked)
    state = swarm.begin(arena, jnp.array([1, 2], jnp.uint32), physics)
    _, seen = swarm.observe(state, arena, physics)
    return seen.view


def test_ahead_is_who_is_heard_and_nearer_to_the_sink(view):
    assert words.somebody_ahead(view).tolist() == [True, True, False, False]
    assert words.send_to_foremost(view).node.tolist() == [2, 2, AGENTS + 2, AGENTS + 2]
    assert not words.sink_in_reach(view).any()


def test_the_chain_stands_at_even_distances(view):
    x, y, far = words.post(view)
    assert x.tolist() == pytest.approx([120, 240, 360, 480])
    assert far.all()
    assert y.tolist() == [0, 0, 0, 0]


def test_turns_come_round_and_never_two_within_four_hops(view):
    def at(t):
        state = dataclasses.replace(view.state, t=jnp.int32(t))
        return dataclasses.replace(view, state=state)

    turns = np.array([words.my_turn(at(t)) for t in range(8)])
    assert (turns.sum(axis=1) == 1).all()
    assert (turns.argmax(axis=1) == np.arange(8) % 4).all()
    before = np.array([words.turn_before(at(t)) for t in range(8)])
    np.testing.assert_array_equal(before[:-1], turns[1:])


def test_next_is_the_next_number_and_behind_the_last_the_sink(view):
    assert words.send_to_next(view).node.tolist() == [1, 2, 3, AGENTS + 1]
    assert words.next_in_reach(view).tolist() == [True, True, False, False]
    assert words.first_in_line(view).tolist() == [True, False, False, False]


def test_lots_are_drawn_in_proportion_to_who_is_heard(view):
    def drawn(t):
        return words.by_lot(dataclasses.replace(view, state=dataclasses.replace(view.state, t=t)))

    share = np.asarray(jax.vmap(drawn)(jnp.arange(4000, dtype=jnp.int32))).mean(axis=0)
    assert share.tolist() == pytest.approx([1 / 3, 1 / 3, 1 / 3, 1], abs=0.03)


def test_anyone_is_any_agent_in_reach(view):
    def drawn(t):
        return words.send_to_anyone(dataclasses.replace(view, state=dataclasses.replace(view.state, t=t))).node

    nodes = np.asarray(jax.vmap(drawn)(jnp.arange(400, dtype=jnp.int32)))
    assert [sorted(set(column.tolist())) for column in nodes.T] == [[1, 2], [0, 2], [0, 1], [AGENTS + 2]]


def test_forces_push_apart_and_pull_toward_the_sink(view):
    x, y, known = words.balance(view)
    assert known.all()
    assert x[2] > view.x[2]  # nobody near ahead: the sink pulls
    assert x[1] > view.x[1]  # two behind, one ahead, all equally far
    assert y[0] > view.y[0]  # off the source, beside which it stands
    np.testing.assert_array_equal(words.off_balance(view), known)


def test_lanes_lie_to_the_right(view):
    x, y, _ = words.lane_to_sink(view)
    assert (x[1:3] > view.x[1:3]).all()
    assert y[1:3].tolist() == [-words.LANE] * 2
    x, y, _ = words.lane_to_source(view)
    assert (x[1:3] < view.x[1:3]).all()
    assert y[1:3].tolist() == [words.LANE] * 2
