"""One episode, step by step. Every function changes `state` and `work` in place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tests.oracle.air import accept, hand_over, list_sends, list_serves, measure_interference, radiate
from tests.oracle.classifier import (
    best_quality,
    choose,
    form_action_set,
    learn,
    learning_rate,
    match_rules,
)
from tests.oracle.model import new_state, new_work
from tests.oracle.motion import arrive, propose, resolve
from tests.oracle.radio import hear_beacons, jam_nodes, notice_jammer
from tests.oracle.randomness import COLLECT, PRIORITY, SHADOWING, stream
from tests.oracle.reward import reward_agents, transfer_progress
from tests.oracle.sensing import (
    enter_neighbours,
    find_roles,
    measure,
    observe,
    share_knowledge,
)
from tests.oracle.strength import credit_of, retire, settle
from tests.oracle.words import NO_ACTION


def sense(state, world, rules, params, key0, key1, t, work):
    """Links, jammer, neighbours, knowledge, roles and the truth of every clause."""
    place = state.place
    s1, s2 = stream(key0, key1, t, SHADOWING)
    active = jam_nodes(place, world, params, s1, s2, work.jam)
    hear_beacons(place, world, rules.channels, work.jam, params, s1, s2, work.floor, work.heard)
    enter_neighbours(place, work.heard, t, state.known_time, state.known_place)
    notice_jammer(place, params, active, work.jam, state.jammer_range)
    n = state.holding.shape[0]
    for i in range(n):
        find_roles(
            i, False, place, world.sink_estimate, state.known_time, state.known_place, work.heard,
            work.role[i], work.distance[i],
        )  # fmt: skip
        measure(i, place, world.sink_estimate, state.jammer_range, params, work.distance[i])
        in_reach = work.heard[i, n] or work.heard[i, n + 1]
        work.truth[i, 0], work.truth[i, 1] = observe(
            state.holding[i], in_reach, state.interference[i], work.distance[i], params
        )


def decide(state, world, rules, params, key0, key1, t, work):
    """Match sets, learning from the previous step, choice of actions, action sets."""
    n = state.holding.shape[0]
    memory = state.past_size.shape[1]
    before, now = (t - 1) % memory, t % memory
    s1, s2 = stream(key0, key1, t, PRIORITY)
    rate = learning_rate(params, t - 1, world.time_limit)
    for i in range(n):
        match = work.match[i]
        size = match_rules(rules.mask[i], work.truth[i], work.matched_truth[i], match, work.match_size[i])
        work.match_size[i] = size
        if t > 0 and state.past_size[i, before] > 0:
            future = best_quality(match, size, state.quality[i])
            learn(
                state.past_set[i, before], state.past_size[i, before], state.reward[i], future, rate, params.beta_q,
                state.quality[i], state.error[i],
            )  # fmt: skip
        work.action[i] = choose(i, n, match, size, state.quality[i], rules.action[i], params.alpha_grasp, s1, s2)
        if t >= memory:
            retire(
                t, state.past_set[i], state.past_size[i], state.past_credit[i], params.trace_decay, state.strength[i]
            )
        state.past_size[i, now] = form_action_set(
            match, size, rules.action[i], work.action[i], state.past_set[i, now], state.usage[i]
        )


def communicate(state, world, rules, params, key0, key1, t, work):
    """Transmissions, packets that change hands and the interference measured; returns the number of transmissions."""
    s1, s2 = stream(key0, key1, t, COLLECT)
    for i in range(work.held.shape[0]):
        work.held[i] = state.holding[i]
    count = list_sends(state, world, params, work)
    count = list_serves(count, state, params, work, s1, s2)
    s1, s2 = stream(key0, key1, t, SHADOWING)
    radiate(count, state.place, world, params, work, s1, s2)
    accept(count, state.holding, rules.channels, params, work)
    hand_over(count, state, work)
    measure_interference(count, rules.channels, params, work, state.interference)
    return count


def move(state, world, params, work):
    """work.moved: where every agent ends the step."""
    propose(state, world, params, work)
    resolve(state, world, params, work)


def earn(state, world, params, t, count, work):
    """Rewards and what they are worth to the remembered action sets."""
    now = t % state.past_size.shape[1]
    transfer_progress(count, state.place, world.sink_estimate, work)
    reward_agents(state, world, params, work, state.reward)
    for i in range(state.reward.shape[0]):
        state.past_credit[i, now] = credit_of(state.reward[i]) if work.action[i] != NO_ACTION else 0.0


def step(state, world, rules, params, key0, key1, t, work):
    """One time-step of the episode with the given key, from any state."""
    sense(state, world, rules, params, key0, key1, t, work)
    decide(state, world, rules, params, key0, key1, t, work)
    count = communicate(state, world, rules, params, key0, key1, t, work)
    move(state, world, params, work)
    earn(state, world, params, t, count, work)
    if (t + 1) % params.sharing_period == 0:
        share_knowledge(
            work.heard, state.known_time, state.known_place, state.jammer_range,
            work.shared_time, work.shared_place, work.shared_range,
        )  # fmt: skip
    arrive(work.moved, state.place)


def is_over(state, world, params, t):
    """Whether every packet is at the sink or the time is up."""
    return t >= world.time_limit or state.depot[1] >= params.packets


def finish(state, world, params, t):
    """After the last step, t steps having been made: its action sets learn, and pending strength is credited."""
    last = (t - 1) % state.past_size.shape[1]
    rate = learning_rate(params, t - 1, world.time_limit)
    for i in range(state.reward.shape[0]):
        if t > 0:
            learn(
                state.past_set[i, last], state.past_size[i, last], state.reward[i], 0.0, rate, params.beta_q,
                state.quality[i], state.error[i],
            )  # fmt: skip
        settle(t, state.past_set[i], state.past_size[i], state.past_credit[i], params.trace_decay, state.strength[i])


def play(state, world, rules, params, key0, key1, work):
    """A whole episode from its first state; returns the number of steps."""
    t = 0
    while not is_over(state, world, params, t):
        step(state, world, rules, params, key0, key1, t, work)
        t += 1
    finish(state, world, params, t)
    return t


class Outcome(NamedTuple):
    """What an episode leaves."""

    fitness: float
    delivered: int
    steps: int
    contribution: np.ndarray  # int64[n]
    quality: np.ndarray  # [n, R]
    strength: np.ndarray  # [n, R] divided by usage, 0 where unused
    error: np.ndarray  # [n, R]
    usage: np.ndarray  # int64[n, R]


def outcome_of(state, world, params, steps):
    """Outcome of a finished episode. Fitness: share of packets delivered less share of time spent."""
    delivered = state.depot[1]
    return Outcome(
        fitness=delivered / params.packets - steps / world.time_limit,
        delivered=delivered,
        steps=steps,
        contribution=state.contribution,
        quality=state.quality,
        strength=state.strength / np.maximum(state.usage, 1),
        error=state.error,
        usage=state.usage,
    )


def run_episode(world, rules, params, key0, key1):
    """One episode with the randomness of the key, two 32-bit words; returns its Outcome."""
    state, work = new_state(world, rules, params), new_work(world, rules)
    steps = play(state, world, rules, params, int(key0), int(key1), work)
    return outcome_of(state, world, params, steps)
