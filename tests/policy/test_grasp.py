"""GRASP: the restricted candidate list, and a uniform draw from it."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from slcs2_jax.grammar.vocabulary import NO_ACTION, PAPER
from slcs2_jax.policy import grasp

choose = jax.jit(grasp.choose)
TRIALS = 20_000


def draws(quality, match, action=None, alpha=0.2, trials=TRIALS, seed=0):
    """How often each action is chosen; by default every rule has an action of its own."""
    count = len(quality)
    action = np.arange(count) if action is None else np.array(action)
    lots = np.random.default_rng(seed).integers(0, 2**32, (count, 1, trials), dtype=np.uint32)
    wide = np.ones(trials)
    got = choose(
        jnp.asarray(np.array(match, bool)[:, None, None] & (wide[None, None] > 0)),
        jnp.asarray((np.array(quality)[:, None, None] * wide).astype(np.float32)),
        jnp.asarray((action[:, None, None] * wide).astype(np.uint8)),
        jnp.asarray(lots),
        jnp.float32(alpha),
    )
    assert got.dtype == jnp.int32
    return np.bincount(np.asarray(got)[0], minlength=256)


def uniform(counts, listed):
    """Only the listed are drawn, and all as often."""
    counts = np.asarray(counts)
    assert counts[listed].sum() == counts.sum()
    assert stats.chisquare(counts[listed]).pvalue > 1e-3


def test_the_draw_is_uniform_over_the_list():
    quality = [1.0, 0.9, 0.85, 0.79, 0.5, 0.0, 0.81]
    uniform(draws(quality, [True] * 7), [0, 1, 2, 6])  # q_grasp = 0.8


def test_rules_that_do_not_match_neither_count_nor_win():
    quality = [5.0, 1.0, 0.9, -7.0, 0.0]
    uniform(draws(quality, [False, True, True, False, True]), [1, 2])


def test_the_threshold_belongs_to_the_list():
    """q_max = 4, q_min = 0, alpha = 0.25: q_grasp = 3, exactly."""
    uniform(draws([4.0, 3.0, np.nextafter(np.float32(3), np.float32(0)), 0.0], [True] * 4, alpha=0.25), [0, 1])


def test_negative_qualities():
    """q_max = -1, q_min = -11: q_grasp = -3."""
    uniform(draws([-1.0, -2.9, -3.1, -11.0], [True] * 4), [0, 1])


@pytest.mark.parametrize("value", [0.0, -3.7, 1e-20, 123.456])
@pytest.mark.parametrize("alpha", [0.0, 0.2, 1.0])
def test_when_all_are_equal_all_are_listed(value, alpha):
    uniform(draws([value] * 6, [True] * 5 + [False], alpha=alpha), [0, 1, 2, 3, 4])


def test_alpha_0_is_greedy():
    uniform(draws([1.0, 2.0, 2.0, 1.999], [True] * 4, alpha=0.0), [1, 2])


def test_alpha_1_is_random():
    uniform(draws([1.0, 2.0, -5.0, 1.999], [True] * 4, alpha=1.0), [0, 1, 2, 3])


def test_with_alpha_1_rounding_leaves_nobody_out():
    """q_max - (q_max - q_min) rounds to less or more than q_min; the worst rule must still be on the list."""
    quality = jnp.asarray(np.random.default_rng(3).normal(0, 1, (2, 500)), jnp.float32)
    worst = jnp.argmin(quality, axis=0)
    lots = (jnp.arange(2)[:, None] == worst).astype(jnp.uint32) << np.uint32(31)  # the worst has drawn the greater lot
    action = jnp.broadcast_to(jnp.arange(2, dtype=jnp.uint8)[:, None], (2, 500))
    got = choose(jnp.ones((2, 500), bool), quality, action, lots, jnp.float32(1))
    assert (got == worst).all(), f"{int((got != worst).sum())} of 500 pairs"


def test_nothing_matches_nothing_is_done():
    assert draws([1.0, 2.0], [False, False], trials=10)[NO_ACTION] == 10


def test_actions_are_as_likely_as_they_have_rules():
    """Three rules for action 40, one for 56, one for 0."""
    counts = draws([1.0] * 5, [True] * 5, action=[40, 56, 40, 0, 40])
    assert stats.chisquare(counts[[0, 40, 56]], [TRIALS / 5, 3 * TRIALS / 5, TRIALS / 5]).pvalue > 1e-3


def test_a_hundred_rules_with_every_action():
    action = np.arange(100) % len(PAPER.actions)
    counts = draws([0.0] * 100, [True] * 100, action=action, seed=4)
    expected = np.bincount(action, minlength=len(PAPER.actions)) * TRIALS / 100
    assert stats.chisquare(counts[: len(PAPER.actions)], expected).pvalue > 1e-3


def test_the_last_of_all_lots_still_wins_when_it_is_the_only_one():
    one, action, lot = jnp.ones((1, 1), bool), jnp.full((1, 1), 7, jnp.uint8), jnp.zeros((1, 1), jnp.uint32)
    got = choose(one, jnp.zeros((1, 1)), action, lot, jnp.float32(0.2))
    assert int(got[0]) == 7


def test_agents_and_instances_choose_for_themselves():
    rng = np.random.default_rng(5)
    shape = (9, 4, 3)
    match, quality = rng.random(shape) < 0.5, rng.normal(0, 1, shape).astype(np.float32)
    match[:, 0, 0] = False
    action = rng.integers(0, len(PAPER.actions), shape).astype(np.uint8)
    lots = rng.integers(0, 2**32, shape, dtype=np.uint32)
    together = np.asarray(choose(*map(jnp.asarray, (match, quality, action, lots)), jnp.float32(0.2)))
    for i in range(4):
        for b in range(3):
            q, m = quality[:, i, b], match[:, i, b]
            if not m.any():
                assert together[i, b] == NO_ACTION
                continue
            bound = q[m].max() - 0.2 * (q[m].max() - q[m].min())
            listed = np.flatnonzero(m & (q >= bound))
            winner = max(listed, key=lambda r, i=i, b=b: (lots[r, i, b] >> 8, action[r, i, b]))
            assert together[i, b] == action[winner, i, b]
