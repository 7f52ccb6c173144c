"""Whole episodes in plain Python: invariants, and learning against a plain record of everything."""

import math

import numpy as np
import pytest

from slcs2_jax.grammar import vocabulary as words
from slcs2_jax.grammar.vocabulary import PAPER
from tests.oracle import geometry, inputs, model
from tests.oracle.episode import finish, is_over, outcome_of, run_episode, step
from tests.oracle.words import NO_ACTION

KINDS = [{}, {"urban": True}, {"jammed": True}, {"urban": True, "jammed": True}]


def trace(world, rules, params, key, steps):
    """Runs an episode; yields (t, state, work) after every step."""
    state, work = model.new_state(world, rules, params), model.new_work(world, rules)
    for t in range(steps):
        step(state, world, rules, params, *key, t, work)
        yield t, state, work


def wall_distance(world, x, y, half):
    """Distance to the nearest wall's surface."""
    apart = math.inf
    for walls, across, along in ((world.vertical, x, y), (world.horizontal, y, x)):
        for line, low, high in zip(*walls, strict=True):
            p, q = geometry.nearest_on_wall(line, low, high, half, across, along)
            apart = min(apart, geometry.distance(p, q, across, along))
    return apart


def check_physics(before, state, world, params):
    """Packets conserved; nobody crosses a wall or comes nearer than the clearance, or than before, to anything."""
    assert state.depot.sum() + state.holding.sum() == params.packets
    assert (state.depot >= 0).all()
    assert (state.history.any(axis=1) == state.holding).all()
    n = len(state.holding)
    for i in range(n):
        old, new = before[i], state.place[i]
        assert np.hypot(*(new - old)) <= params.speed + 1e-9
        assert geometry.crossings(world.vertical, *old, *new) == 0
        assert geometry.crossings(world.horizontal, *old[::-1], *new[::-1]) == 0
        then = wall_distance(world, *old, params.half_thickness)
        assert wall_distance(world, *new, params.half_thickness) >= min(then, params.clearance) - 1e-9
        for j in range(i):
            then = np.hypot(*(before[j] - old))
            assert np.hypot(*(state.place[j] - new)) >= min(then, params.clearance) - 1e-9


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(2))
def test_invariants_of_random_episodes(make, params, kind, seed):
    world, rules = make.world(seed, **kind), make.rules(seed, grammar=make.both, clauses=2)
    before = world.start.copy()
    for _, state, _ in trace(world, rules, params, (seed, 1), 60):
        check_physics(before, state, world, params)
        before = state.place.copy()
    bound = (math.log(world.fixed[1, 0] * 3) + params.speed + params.cost_move) / (1 - params.beta_q)
    assert np.isfinite(state.quality).all()
    assert np.abs(state.quality).max() <= bound
    assert (state.error >= 0).all()


def test_learning_equals_a_plain_record(make, params):
    """Quality, error, usage and strength of every rule from the lists of match sets, action sets and rewards."""
    world, rules = make.world(4, time_limit=50), make.rules(4, clauses=1)
    n, count = rules.action.shape
    matched, acted, rewards = [], [], []
    for t, state, work in trace(world, rules, params, (8, 9), 50):
        matched.append([set(work.match[i, : work.match_size[i]].tolist()) for i in range(n)])
        chosen = [{r for r in matched[t][i] if rules.action[i, r] == work.action[i]} for i in range(n)]
        acted.append(chosen)
        rewards.append(state.reward.copy())
    finish(state, world, params, 50)
    assert any(action == NO_ACTION for action in work.action) or all(acted[-1])

    quality, error, strength, usage = (np.zeros((n, count)) for _ in range(4))
    a, b = params.alpha_q, params.beta_q
    for i in range(n):
        for t in range(50):
            future = max((quality[i, r] for r in matched[t + 1][i]), default=0.0) if t < 49 else 0.0
            for r in acted[t][i]:
                usage[i, r] += 1
                error[i, r] = (1 - a) * error[i, r] + a * abs(rewards[t][i] - quality[i, r])
                quality[i, r] = (1 - a) * quality[i, r] + a * (rewards[t][i] + b * future)
                for later in range(t, min(t + params.bp_max + 1, 50)):
                    rho = rewards[later][i]
                    strength[i, r] += params.trace_decay ** (later - t) * np.sign(rho) * np.log10(abs(rho) + 1)
    outcome = outcome_of(state, world, params, 50)
    np.testing.assert_allclose(outcome.quality, quality, atol=1e-12)
    np.testing.assert_allclose(outcome.error, error, atol=1e-12)
    np.testing.assert_array_equal(outcome.usage, usage)
    np.testing.assert_allclose(outcome.strength, strength / np.maximum(usage, 1), atol=1e-12)


def courier(time_limit=400):
    """One scene in which rules by hand deliver: collect near the source, carry, deliver."""
    clauses = {"held": 2, "none": 4, "reach": 8}
    mask = np.zeros((2, 3, 4), np.uint32)
    mask[:, 0, 0] = clauses["none"] | clauses["reach"]  # no packet held & node in reach => collect
    mask[:, 1, 0] = clauses["held"] | clauses["reach"]  # packet held & node in reach => send to sink
    mask[:, 2, 0] = clauses["none"] | 16  # no packet & no node in reach => move toward source
    actions = [PAPER.collect_action(), PAPER.send_action(words.SINK), PAPER.move_action(words.TOWARD, words.SOURCE)]
    rules = inputs.make_rules(mask, np.array([actions] * 2), (True, False, False))
    return inputs.make_world(start=[(50, 0), (60, 20)], sink=(100, 0), time_limit=time_limit), rules


def test_an_episode_ends_with_the_last_packet(params):
    world, rules = courier()
    outcome = run_episode(world, rules, params._replace(packets=5), 3, 4)
    assert outcome.delivered == 5
    assert outcome.steps < 60
    assert outcome.fitness == 1 - outcome.steps / world.time_limit
    assert outcome.contribution.sum() == 5  # nobody relays here


def test_no_delivery_is_exactly_minus_one(make, params):
    world, rules = make.world(1, distance=5000.0, time_limit=7), make.rules(1)
    outcome = run_episode(world, rules, params, 1, 2)
    assert (outcome.fitness, outcome.delivered, outcome.steps) == (-1.0, 0, 7)


def test_nothing_matches_nothing_happens(make, params):
    world = make.world(1, time_limit=5)
    rules = make.rules(1)
    rules.mask[:] = 0b110  # packet held and no packet held
    outcome = run_episode(world, rules, params, 1, 2)
    for field in (outcome.quality, outcome.strength, outcome.error, outcome.usage):
        assert not field.any()


def test_the_same_key_gives_the_same_episode_and_another_key_another(make, params):
    world, rules = make.world(2, time_limit=20), make.rules(2)
    one, two, other = (run_episode(world, rules, params, 5, key) for key in (6, 6, 7))
    np.testing.assert_array_equal(one.quality, two.quality)
    assert (one.quality != other.quality).any()


def test_is_over(make, params):
    case = make.place([(0, 0), (5, 5)], time_limit=3, params=params)
    assert not is_over(case.state, case.world, params, 2)
    assert is_over(case.state, case.world, params, 3)
    case.state.depot[1] = params.packets
    assert is_over(case.state, case.world, params, 0)
