"""The compiled oracle equals the plain one, and holds the invariants over longer episodes."""

import numpy as np
import pytest

pytest.importorskip("numba")

from tests.oracle import compiled, episode, model

pytestmark = pytest.mark.slow  # compiling takes some twenty seconds when nothing is cached

KINDS = [{}, {"urban": True}, {"jammed": True}, {"urban": True, "jammed": True}]


def assert_equal(one, other):
    for name in one._fields:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(2))
def test_outcomes_are_identical(make, params, kind, seed):
    world = make.world(seed, time_limit=45, **kind)
    rules = make.rules(seed, grammar=(make.main, make.both)[seed])
    plain = episode.run_episode(world, rules, params, seed, 77)
    assert_equal(plain, compiled.run_episode(world, rules, params, seed, 77))


def test_every_step_is_identical_from_a_state_in_the_middle(make, params):
    world, rules = make.world(5, urban=True, jammed=True), make.rules(5, grammar=make.both)
    library = compiled.library()
    fast, work = model.new_state(world, rules, params), model.new_work(world, rules)
    for t in range(40):
        library.step(fast, world, rules, params, 1, 2, t, work)
    plain = model.State(*(array.copy() for array in fast))
    for t in range(40, 50):
        library.step(fast, world, rules, params, 1, 2, t, work)
        episode.step(plain, world, rules, params, 1, 2, t, model.new_work(world, rules))
        assert_equal(plain, fast)


def test_many_episodes_in_parallel_equal_one_by_one(make, params):
    worlds = [make.world(s, urban=s % 2 == 1, jammed=s > 2, time_limit=200) for s in range(5)]
    rules = [make.rules(s) for s in range(5)]
    keys = np.array([[s, 2**32 - 1 - s] for s in range(5)], np.uint32)
    together = compiled.run_many(worlds, rules, params, keys)
    for e in range(5):
        alone = compiled.run_episode(worlds[e], rules[e], params, *keys[e])
        assert_equal(alone, type(alone)(*(field[e] for field in together)))


@pytest.mark.parametrize("kind", KINDS)
def test_long_episodes_keep_their_invariants(make, params, kind):
    world = make.world(9, agents=8, time_limit=3000, **kind)
    rules = make.rules(9, agents=8, count=60, grammar=make.both)
    library = compiled.library()
    state, work = model.new_state(world, rules, params), model.new_work(world, rules)
    for t in range(3000):
        library.step(state, world, rules, params, 3, 4, t, work)
        assert state.depot.sum() + state.holding.sum() == params.packets
        apart = np.hypot(*(state.place[:8, None] - state.place[None, :8]).transpose(2, 0, 1)) + 9 * np.eye(8)
        assert apart.min() >= params.clearance - 1e-9
    assert np.isfinite(state.quality).all()
    assert state.contribution.sum() >= state.depot[1]
