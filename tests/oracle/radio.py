"""Links between nodes, the jammer and who hears whom (docs/model.md, Radio).

A link's power is computed where it is needed: for every pair in range of beacons, and for data and jammer towards all.
It stays logarithmic as long as it is only compared. `world` gives the walls, (s1, s2) the step's stream of shadowing.
"""

from __future__ import annotations

import math

from tests.oracle.geometry import crossings, distance, square_distance
from tests.oracle.randomness import draw, normal


def faded_power(u, v, square, nodes, params, s1, s2):
    """Log power (mW) received over the link of nodes u < v at full power, walls left out; `square` distance.

    Log-distance path loss floored at the reference distance, and one normal draw per pair and step.
    """
    path = max(square / (params.reference_distance * params.reference_distance), 1.0)
    shadowing = params.log_shadowing * normal(draw(s1, s2, u * nodes + v))
    return params.log_reference - params.half_exponent * math.log(path) + shadowing


def wall_loss(u, v, place, vertical, horizontal, params):
    """Log loss by the walls between two nodes."""
    walls = crossings(vertical, place[u, 0], place[u, 1], place[v, 0], place[v, 1])
    walls += crossings(horizontal, place[u, 1], place[u, 0], place[v, 1], place[v, 0])
    return walls * params.log_wall


def link_power(u, v, place, vertical, horizontal, params, s1, s2):
    """Log power (mW) received over the link of two nodes, in either direction, at full power."""
    first, second = min(u, v), max(u, v)
    square = square_distance(place[u, 0], place[u, 1], place[v, 0], place[v, 1])
    power = faded_power(first, second, square, place.shape[0], params, s1, s2)
    return power - wall_loss(first, second, place, vertical, horizontal, params)


def jam_nodes(place, world, params, s1, s2, jam):
    """jam[v]: the jammer's power (mW) at agent, source or sink v; 0 everywhere while no beacon of theirs reaches it.

    Beacons go out on every channel in use, so a jammer that hears anything hears it on the first of them.
    """
    nodes = jam.shape[0]
    active = False
    if world.has_jammer:
        for v in range(nodes):
            jam[v] = link_power(v, nodes, place, world.vertical, world.horizontal, params, s1, s2)
            active = active or jam[v] >= params.log_receive
    for v in range(nodes):
        jam[v] = math.exp(jam[v]) if active else 0.0
    return active


def jammed_channel(channels):
    """The first channel in use."""
    k = 0
    while not channels[k]:
        k += 1
    return k


def noise_on(channel, v, jam, channels, params):
    """Thermal noise and jammer at node v on a channel, mW."""
    if channel == jammed_channel(channels):
        return params.noise + jam[v]
    return params.noise


def beacon_floor(v, jam, channels, params):
    """The weakest log power at which agent v decodes a beacon, on the best of the channels in use."""
    if jam[v] == 0.0:
        return max(params.log_receive, params.log_noise + params.log_sinr)
    quietest = params.noise + jam[v]
    for k in range(channels.shape[0]):
        if channels[k]:
            quietest = min(quietest, noise_on(k, v, jam, channels, params))
    return max(params.log_receive, math.log(quietest) + params.log_sinr)


def hear_beacons(place, world, channels, jam, params, s1, s2, floor, heard):
    """heard[v, u]: agent v decodes the beacon of agent, source or sink u. floor[n] is scratch."""
    n, nodes = heard.shape[0], place.shape[0]
    vertical, horizontal = world.vertical, world.horizontal
    walled = vertical.line.shape[0] + horizontal.line.shape[0] > 0
    for v in range(n):
        heard[v, v] = False
        floor[v] = beacon_floor(v, jam, channels, params)
    for u in range(n):
        for v in range(u + 1, n + 2):
            square = square_distance(place[u, 0], place[u, 1], place[v, 0], place[v, 1])
            power = params.log_nothing
            if square <= params.square_range:
                power = faded_power(u, v, square, nodes, params, s1, s2)
                if walled and power >= params.log_receive:
                    power -= wall_loss(u, v, place, vertical, horizontal, params)
            heard[u, v] = power >= floor[u]
            if v < n:
                heard[v, u] = power >= floor[v]


def notice_jammer(place, params, active, jam, jammer_range):
    """Agents that receive the jammer's noise know it; its range is the greatest distance at which they did."""
    if not active:
        return
    jammer = place.shape[0] - 1
    for v in range(jammer_range.shape[0]):
        if jam[v] >= params.receive:
            reach = distance(place[v, 0], place[v, 1], place[jammer, 0], place[jammer, 1])
            jammer_range[v] = max(jammer_range[v], reach)
