"""A rule is in the match set when every clause of its condition holds."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.policy.matching import match_set


def words(*clauses, width=4):
    """A set of clauses as words."""
    out = np.zeros(width, np.uint32)
    for k in clauses:
        out[k // 32] |= np.uint32(1 << (k % 32))
    return out


def matches(conditions, true, width=4):
    mask = np.stack([words(*c, width=width) for c in conditions], axis=1)[:, :, None]
    return np.asarray(match_set(jnp.asarray(mask), jnp.asarray(words(*true)[:, None])))[:, 0].tolist()


def test_by_hand():
    conditions = [(0,), (0, 1), (31, 32), (96,), (5, 40, 70, 95), (2,)]
    assert matches(conditions, (0, 5, 31, 32, 40, 70, 95)) == [True, False, True, False, True, False]
    assert matches(conditions, ()) == [False] * 6
    assert matches(conditions, range(97)) == [True] * 6


@pytest.mark.parametrize("clause", [0, 31, 32, 63, 64, 95, 96])
def test_a_single_missing_clause_is_enough(clause):
    everything = [k for k in range(97) if k != clause]
    assert matches([range(97), everything, (clause,)], everything) == [False, True, False]


def test_rules_of_fewer_words_match_against_wider_truth():
    assert matches([(0, 95), (0, 64)], (0, 95, 96), width=3) == [True, False]


def test_random_sets_against_python_sets():
    rng = np.random.default_rng(0)
    rules = [[set(rng.choice(97, rng.integers(1, 5), replace=False).tolist()) for _ in range(3)] for _ in range(50)]
    true = [[set(rng.choice(97, 70, replace=False).tolist()) for _ in range(2)] for _ in range(3)]
    mask = np.array([[words(*c) for c in row] for row in rules])  # [R, n, W]
    truth = np.array([[words(*c) for c in row] for row in true])  # [n, B, W]
    got = np.asarray(match_set(jnp.asarray(mask.transpose(2, 0, 1)[..., None]), jnp.asarray(truth.transpose(2, 0, 1))))
    assert got.shape == (50, 3, 2)
    expected = [[[rules[r][i] <= true[i][b] for b in range(2)] for i in range(3)] for r in range(50)]
    np.testing.assert_array_equal(got, expected)
    assert 0.1 < got.mean() < 0.9
