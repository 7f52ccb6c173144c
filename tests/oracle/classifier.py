"""The rule-set classifier: matching, learning and choice (docs/model.md, Choice and learning), one agent at a time."""

from __future__ import annotations

from tests.oracle.randomness import draw
from tests.oracle.words import NO_ACTION


def match_rules(mask, truth, matched_truth, match, size):
    """Lists the rules whose every clause holds: match[:size]; returns size.

    mask[R, 2] and truth[2] of one agent. While the truth stays what it was, so does the list; size < 0: none yet.
    """
    low, high = truth[0], truth[1]
    if size >= 0 and low == matched_truth[0] and high == matched_truth[1]:
        return size
    matched_truth[0] = low
    matched_truth[1] = high
    size = 0
    for r in range(mask.shape[0]):
        match[size] = r  # overwritten unless it counts: quicker than a branch that nobody can foresee
        size += (mask[r, 0] & ~low) | (mask[r, 1] & ~high) == 0
    return size


def best_quality(match, size, quality):
    """Greatest quality in the match set, 0 if it is empty."""
    if size == 0:
        return 0.0
    best = quality[match[0]]
    for m in range(1, size):
        best = max(best, quality[match[m]])
    return best


def learning_rate(params, t, time_limit):
    """alpha_q for what was done at step t: linear from its first to its final value."""
    return params.alpha_q + (params.alpha_q_final - params.alpha_q) * t / time_limit


def learn(members, size, reward, future, rate, beta, quality, error):
    """Moves error and quality of one action set towards what the step has shown; `future` is the next best quality."""
    target = reward + beta * future
    for m in range(size):
        r = members[m]
        error[r] += rate * (abs(reward - quality[r]) - error[r])
        quality[r] += rate * (target - quality[r])


def choose(i, agents, match, size, quality, action, alpha, s1, s2):
    """GRASP: the action of a rule drawn uniformly from those of the match set with quality >= q_grasp.

    The greatest of the rules' draws decides, on ties the greater action. NO_ACTION if nothing matches.
    """
    if size == 0:
        return NO_ACTION
    best = quality[match[0]]
    worst = best
    for m in range(1, size):
        q = quality[match[m]]
        best = max(best, q)
        worst = min(worst, q)
    bar = best - alpha * (best - worst)
    greatest = -1
    for m in range(size):
        r = match[m]
        if quality[r] >= bar:
            key = (draw(s1, s2, int(r) * agents + i) >> 8) * 256 + int(action[r])
            greatest = max(greatest, key)
    return greatest % 256


def form_action_set(match, size, action, chosen, members, usage):
    """Lists the rules of the match set with the chosen action, members[:count], and counts their use; returns count."""
    count = 0
    for m in range(size):
        r = match[m]
        if action[r] == chosen:
            members[count] = r
            count += 1
            usage[r] += 1
    return count
