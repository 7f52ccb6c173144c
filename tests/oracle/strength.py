"""Strength: every action set earns g(reward) of its own step and of the bp_max steps after it, decayed by age.

An action set is credited once, when its last share is known: the sum of decay^k g[t + k], k = 0..bp_max, goes to
each member.
Memory of one agent: action sets and g by slot t % L, L = bp_max + 1.
"""

from __future__ import annotations

import math


def credit_of(reward):
    """g(reward) = log10(|reward| + 1) with the sign of the reward."""
    return math.copysign(math.log10(abs(reward) + 1.0), reward)


def add_strength(members, size, credit, strength):
    """Credits one action set."""
    for m in range(size):
        strength[members[m]] += credit


def retire(t, past_set, past_size, past_credit, decay, strength):
    """Credits the action set of step t - L, whose slot step t takes over."""
    memory = past_size.shape[0]
    oldest = t % memory
    if past_size[oldest] > 0:
        credit = 0.0
        for k in range(oldest - 1, -1, -1):  # newest first
            credit = credit * decay + past_credit[k]
        for k in range(memory - 1, oldest - 1, -1):
            credit = credit * decay + past_credit[k]
        add_strength(past_set[oldest], past_size[oldest], credit, strength)


def settle(t, past_set, past_size, past_credit, decay, strength):
    """Credits the action sets of the steps before t that are still remembered with what they have earned so far."""
    memory = past_size.shape[0]
    credit = 0.0
    for age in range(1, min(memory, t) + 1):
        k = (t - age) % memory
        credit = credit * decay + past_credit[k]
        add_strength(past_set[k], past_size[k], credit, strength)
