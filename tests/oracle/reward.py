"""Reward of a step (docs/model.md, Choice and learning)."""

from __future__ import annotations

import math

from tests.oracle.air import inbox, is_move
from tests.oracle.geometry import distance
from tests.oracle.words import NO_ACTION


def reward_of(progress, returned, cost):
    """rho = ln(|progress| + 1) with its sign, plus the way back to the source, less the action's cost."""
    return math.copysign(math.log(abs(progress) + 1.0), progress) + returned - cost


def transfer_progress(count, place, sink_estimate, work):
    """progress[n] from packets that changed hands: what the way to the sink became shorter, for sender and receiver."""
    n = work.held.shape[0]
    work.progress[:] = 0.0
    for m in range(count):
        u, v = work.sender[m], work.receiver[m]
        if work.accepted[inbox(m, n, work)] == m:
            gain = distance(place[u, 0], place[u, 1], sink_estimate[0], sink_estimate[1])
            gain -= distance(place[v, 0], place[v, 1], sink_estimate[0], sink_estimate[1])
            if u < n:
                work.progress[u] = gain
            if v < n:
                work.progress[v] = gain


def reward_agents(state, world, params, work, reward):
    """reward[n], from where the agents were (state.place) and where they end (work.moved); 0 without an action."""
    n = reward.shape[0]
    for i in range(n):
        if work.action[i] == NO_ACTION:
            reward[i] = 0.0
            continue
        progress = work.progress[i]
        if work.held[i] and state.holding[i]:
            progress = approach(i, state.place, work.moved, world.sink_estimate[0], world.sink_estimate[1])
        returned = 0.0
        if not work.held[i] and not state.holding[i]:
            returned = approach(i, state.place, work.moved, state.place[n, 0], state.place[n, 1])
        cost = params.cost_move if is_move(work.action[i]) else params.cost_communicate
        reward[i] = reward_of(progress, returned, cost)


def approach(i, place, moved, x, y):
    """How much nearer agent i comes to a point."""
    if moved[i, 0] == place[i, 0] and moved[i, 1] == place[i, 1]:
        return 0.0
    return distance(place[i, 0], place[i, 1], x, y) - distance(moved[i, 0], moved[i, 1], x, y)
