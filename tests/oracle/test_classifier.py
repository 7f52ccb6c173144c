"""Matching, learning and choice."""

import numpy as np
import pytest
from scipy import stats

from tests.oracle import classifier, inputs
from tests.oracle.randomness import PRIORITY, draw, stream


def rules_of(*clauses):
    """mask[R, 2] of rules with these clauses."""
    words = np.zeros((1, len(clauses), 4), np.uint32)
    for r, numbers in enumerate(clauses):
        for k in numbers:
            words[0, r, k // 32] |= np.uint32(1 << (k % 32))
    return inputs.pack_clauses(words)[0]


def matches(mask, truth_clauses, work=None):
    truth = rules_of(truth_clauses)[0]
    seen, match, size = work or (np.zeros(2, np.int64), np.zeros(len(mask), np.uint16), -1)
    size = classifier.match_rules(mask, truth, seen, match, size)
    return match[:size].tolist(), (seen, match, size)


def test_a_rule_matches_when_all_its_clauses_hold():
    mask = rules_of((1, 96), (1,), (49, 50), (2,))
    assert matches(mask, (1, 49, 96))[0] == [0, 1]
    assert matches(mask, (1, 49, 50))[0] == [1, 2]
    assert matches(mask, (0,))[0] == []


def test_match_sets_are_remembered_only_for_the_same_truth():
    mask = rules_of((1,), (2,))
    first, work = matches(mask, (1,))
    same, work = matches(mask, (1,), work)
    assert first == same == [0]
    assert matches(mask, (2,), work)[0] == [1]


def test_learning_by_hand():
    quality, error = np.array([1.0, -2.0, 5.0]), np.array([0.0, 0.4, 7.0])
    classifier.learn(np.array([0, 1]), 2, 0.5, 2.0, 0.15, 0.71, quality, error)
    np.testing.assert_allclose(error, [0.15 * 0.5, 0.85 * 0.4 + 0.15 * 2.5, 7.0])
    np.testing.assert_allclose(quality, [0.85 + 0.15 * (0.5 + 1.42), -1.7 + 0.15 * (0.5 + 1.42), 5.0])


def test_best_quality_is_zero_without_a_match():
    quality = np.array([-3.0, -1.0])
    assert classifier.best_quality(np.array([0, 1]), 2, quality) == -1.0
    assert classifier.best_quality(np.array([0, 1]), 0, quality) == 0.0


def test_learning_rate_runs_linearly_to_its_final_value(params):
    falling = params._replace(alpha_q=0.2, alpha_q_final=0.1)
    assert [classifier.learning_rate(falling, t, 100) for t in (0, 50, 100)] == pytest.approx([0.2, 0.15, 0.1])
    assert classifier.learning_rate(params, 77, 100) == params.alpha_q


def choose(quality, t=0, agent=2, alpha=0.2, action=None):
    quality = np.array(quality, float)
    match = np.arange(len(quality))
    action = match.astype(np.uint8) if action is None else action
    return classifier.choose(agent, 5, match, len(match), quality, action, alpha, *stream(1, 2, t, PRIORITY))


def test_grasp_draws_uniformly_from_the_restricted_list():
    quality = [1.0, 0.0, 0.8, -5.0, -0.2, -0.21]  # bar at 1 - 0.2 * 6
    counts = np.bincount([choose(quality, t) for t in range(4000)], minlength=6)
    assert counts[[3, 5]].sum() == 0
    assert stats.chisquare(counts[[0, 1, 2, 4]]).pvalue > 1e-3


def test_all_equal_qualities_are_all_on_the_list():
    assert len({choose([0.3] * 6, t) for t in range(200)}) == 6
    assert {choose([0.3, 0.2], t, alpha=0.0) for t in range(50)} == {0}


def test_the_greatest_draw_decides_and_nothing_matches_nothing():
    words = stream(1, 2, 9, PRIORITY)
    draws = [draw(*words, r * 5 + 2) >> 8 for r in range(6)]
    assert choose([0.0] * 6, t=9) == np.argmax(draws)
    empty = np.zeros(0, np.uint16)
    assert classifier.choose(0, 5, empty, 0, np.zeros(1), np.zeros(1), 0.2, *words) == classifier.NO_ACTION


def test_action_set_has_all_matching_rules_with_the_action():
    members, usage = np.zeros(4, np.uint16), np.zeros(4, np.int64)
    action = np.array([7, 8, 7, 7], np.uint8)
    count = classifier.form_action_set(np.array([0, 1, 3]), 3, action, 7, members, usage)
    assert members[:count].tolist() == [0, 3]
    np.testing.assert_array_equal(usage, [1, 0, 0, 1])
