"""What is on the air: collecting, sending, who receives, where packets go (docs/model.md, Radio and Agents).

Transmissions are listed: agents by index, then the source by channel.
"""

from __future__ import annotations

import math

from slcs2_jax.grammar.vocabulary import FULL, SINK, SOURCE
from tests.oracle.radio import link_power, noise_on
from tests.oracle.randomness import draw
from tests.oracle.sensing import find_roles
from tests.oracle.words import CHANNEL, COLLECT, KIND, MOVE, POWER, SEND, TARGET


def is_move(action):
    """Whether the action moves the agent."""
    return KIND[action] == MOVE


def is_collect(action):
    """Whether the action asks the source for a packet."""
    return KIND[action] == COLLECT


def is_send(action):
    """Whether the action sends a packet."""
    return KIND[action] == SEND


def power_of(action, params):
    """Power of a collect or send action, as a fraction of full power."""
    return 1.0 if POWER[action] == FULL else params.half_power


def send_target(i, action, place, world, state, heard, reachable, apart):
    """The node that a send action of agent i is for, -1 if it is not in reach."""
    n = heard.shape[0]
    target = TARGET[action]
    if target == SOURCE:
        return n if heard[i, n] else -1
    if target == SINK:
        return n + 1 if heard[i, n + 1] else -1
    find_roles(i, True, place, world.sink_estimate, state.known_time, state.known_place, heard, reachable, apart)
    return reachable[target]


def list_sends(state, world, params, work):
    """Agents that hold a packet and send it to a node in reach; returns how many transmissions."""
    count = 0
    for i in range(work.heard.shape[0]):
        action = work.action[i]
        if not (is_send(action) and state.holding[i]):
            continue
        target = send_target(i, action, state.place, world, state, work.heard, work.reachable, work.reach_distance)
        if target >= 0:
            work.sender[count] = i
            work.receiver[count] = target
            work.channel[count] = CHANNEL[action]
            work.power[count] = power_of(action, params)
            count += 1
    return count


def served(channel, action, holding, heard, s1, s2):
    """The agent that the source serves on a channel: one at random of those that ask, hear it and hold nothing."""
    n = holding.shape[0]
    agent = -1
    greatest = -1
    for i in range(n):
        if is_collect(action[i]) and CHANNEL[action[i]] == channel and heard[i, n] and not holding[i]:
            bits = draw(s1, s2, i)
            if bits > greatest:
                agent, greatest = i, bits
    return agent


def list_serves(count, state, params, work, s1, s2):
    """Appends the source's transmissions: one per channel, no more than packets wait; returns the new count."""
    n = state.holding.shape[0]
    waiting = state.depot[0]
    asked = False
    for i in range(n):
        asked = asked or is_collect(work.action[i])
    if not asked:
        return count
    for channel in range(3):
        agent = served(channel, work.action, state.holding, work.heard, s1, s2)
        if agent >= 0 and waiting > 0:
            work.sender[count] = n
            work.receiver[count] = agent
            work.channel[count] = channel
            work.power[count] = power_of(work.action[agent], params)
            waiting -= 1
            count += 1
    return count


def radiate(count, place, world, params, work, s1, s2):
    """signal[m, v]: power of transmission m at agent, source or sink v; and who transmits on which channel.

    (s1, s2): the stream of shadowing.
    """
    nodes = place.shape[0] - 1
    vertical, horizontal = world.vertical, world.horizontal
    work.transmits[:] = False
    for m in range(count):
        u = work.sender[m]
        work.transmits[u, work.channel[m]] = True
        for v in range(nodes):
            if v != u:
                power = link_power(u, v, place, vertical, horizontal, params, s1, s2)
                work.signal[m, v] = work.power[m] * math.exp(power)
            else:
                work.signal[m, v] = 0.0


def disturbance(v, channel, wanted, count, channels, params, work):
    """Noise, jammer and every data signal on the channel at node v but the wanted one (-1: none) and v's own, mW."""
    power = noise_on(channel, v, work.jam, channels, params)
    for m in range(count):
        if m != wanted and work.channel[m] == channel and work.sender[m] != v:
            power += work.signal[m, v]
    return power


def is_decoded(m, count, holding, channels, params, work):
    """Whether the receiver of transmission m can take it: strong and clear, and the receiver silent there and free.

    Only agents can be other than free: source and sink take any number of packets.
    """
    n = holding.shape[0]
    v, channel = work.receiver[m], work.channel[m]
    if v <= n and work.transmits[v, channel]:
        return False
    if v < n and holding[v]:
        return False
    wanted = work.signal[m, v]
    if wanted < params.receive:
        return False
    return wanted >= params.sinr * disturbance(v, channel, m, count, channels, params, work)


def inbox(m, n, work):
    """Where transmission m competes: with the agent's others, at the source and the sink with those on its channel."""
    v = work.receiver[m]
    if v < n:
        return v
    return n + (v - n) * 3 + work.channel[m]


def accept(count, holding, channels, params, work):
    """accepted[inbox]: the strongest decoded transmission, on ties the first listed, -1 if there is none."""
    n = holding.shape[0]
    work.accepted[:] = -1
    for m in range(count):
        if not is_decoded(m, count, holding, channels, params, work):
            continue
        box, v = inbox(m, n, work), work.receiver[m]
        rival = work.accepted[box]
        if rival < 0 or work.signal[m, v] > work.signal[rival, v]:
            work.accepted[box] = m


def hand_over(count, state, work):
    """Moves the accepted packets, their histories and the contributions of those that brought one to the sink."""
    n = state.holding.shape[0]
    for m in range(count):
        if work.accepted[inbox(m, n, work)] != m:
            continue
        u, v = work.sender[m], work.receiver[m]
        if u == n:
            state.depot[0] -= 1
        else:
            state.holding[u] = False
        if v < n:
            state.holding[v] = True
            for i in range(n):
                state.history[v, i] = i == v or (u < n and state.history[u, i])
        elif v == n:
            state.depot[0] += 1
        else:
            state.depot[1] += 1
            for i in range(n):
                state.contribution[i] += state.history[u, i]
        if u < n:
            state.history[u, :] = False


def measure_interference(count, channels, params, work, interference):
    """NI of the step, mW per agent and channel: everything but the agent's own signal and the one it accepted."""
    for v in range(interference.shape[0]):
        for channel in range(3):
            interference[v, channel] = noise_on(channel, v, work.jam, channels, params)
        for m in range(count):
            if m != work.accepted[v] and work.sender[m] != v:
                interference[v, work.channel[m]] += work.signal[m, v]
