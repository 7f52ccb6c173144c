"""Quality and error of the last action set, once the next match set is known."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.policy import qlearning

ALPHA, BETA = 0.15, 0.71

update = jax.jit(qlearning.update)


def learn(quality, error, members, reward, match, alpha=ALPHA, beta=BETA):
    """One agent: new quality and error."""
    column = [np.array(a, t)[:, None] for a, t in ((quality, np.float32), (error, np.float32), (members, bool))]
    matched = np.array(match, bool)[:, None]
    ahead = qlearning.best_ahead(column[0], matched)
    q, e = update(*column, np.float32([reward]), ahead, jnp.float32(alpha), jnp.float32(beta))
    return np.asarray(q)[:, 0], np.asarray(e)[:, 0]


def test_by_hand():
    q, e = learn([1.0, 2.0, 3.0], [0.5, 0.0, 0.1], [True, False, True], 4.0, [False, True, False])
    np.testing.assert_allclose(q, [0.85 * 1 + 0.15 * (4 + 0.71 * 2), 2, 0.85 * 3 + 0.15 * (4 + 0.71 * 2)], rtol=1e-6)
    np.testing.assert_allclose(e, [0.85 * 0.5 + 0.15 * 3, 0, 0.85 * 0.1 + 0.15 * 1], rtol=1e-6)


def test_nothing_ahead_counts_as_0_even_if_all_qualities_are_negative():
    q, _ = learn([-5.0, -6.0], [0, 0], [True, True], 1.0, [False, False])
    np.testing.assert_allclose(q, [0.85 * -5 + 0.15, 0.85 * -6 + 0.15], rtol=1e-6)


def test_the_best_ahead_may_be_negative():
    q, _ = learn([-5.0, -6.0], [0, 0], [True, False], 1.0, [True, True])
    assert q[0] == pytest.approx(0.85 * -5 + 0.15 * (1 - 0.71 * 5))


def test_the_best_ahead_is_taken_before_the_update():
    """The only rule that matches next is itself a member: its quality before counts."""
    q, _ = learn([10.0], [0.0], [True], 0.0, [True])
    assert q[0] == pytest.approx(0.85 * 10 + 0.15 * 0.71 * 10)


def test_the_error_is_of_the_reward_alone_and_of_the_quality_before():
    _, e = learn([10.0], [1.0], [True], 4.0, [True])
    assert e[0] == pytest.approx(0.85 * 1 + 0.15 * 6)


def test_who_is_not_a_member_learns_nothing():
    q, e = learn([1.0, 2.0], [3.0, 4.0], [False, False], 100.0, [True, True])
    assert q.tolist() == [1, 2]
    assert e.tolist() == [3, 4]


@pytest.mark.parametrize(("alpha", "quality"), [(0.0, 2.0), (1.0, 5.0 + 0.71 * 3.0)])
def test_the_ends_of_the_learning_rate(alpha, quality):
    q, _ = learn([2.0, 3.0], [0, 0], [True, False], 5.0, [False, True], alpha=alpha)
    assert q[0] == pytest.approx(quality)


def test_each_instance_has_its_own_rate():
    q, e = (jnp.full((1, 1, 2), 2.0), jnp.zeros((1, 1, 2)))
    yes, nothing = jnp.ones((1, 1, 2), bool), jnp.zeros((1, 2))
    got, _ = update(q, e, yes, jnp.full((1, 2), 10.0), nothing, jnp.array([0.5, 0.1]), jnp.float32(BETA))
    np.testing.assert_allclose(np.asarray(got)[0, 0], [6.0, 2.8], rtol=1e-6)


def test_it_converges_to_the_discounted_return():
    """A rule that always matches and earns 1: q = 1 / (1 - beta); its error tends to |1 - q|."""
    q, e = np.zeros(1), np.zeros(1)
    for _ in range(400):
        q, e = learn(q, e, [True], 1.0, [True])
    assert q[0] == pytest.approx(1 / (1 - BETA), rel=1e-4)
    assert e[0] == pytest.approx(1 / (1 - BETA) - 1, rel=1e-3)
