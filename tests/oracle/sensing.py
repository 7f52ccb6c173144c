"""What an agent knows and observes (docs/model.md, Agents).

Everything an agent computes about the sink uses the place where it believes the sink.
"""

from __future__ import annotations

import math

from tests.oracle.geometry import SLACK, distance, nearest_on_wall, rank, square_distance
from tests.oracle.words import (
    COMPARE,
    COMPARE_JAMMER,
    NO_NODE_IN_REACH,
    NO_PACKET_HELD,
    NODE_IN_REACH,
    NOISE,
    OPERANDS,
    PACKET_HELD,
    SPLIT,
)

SO, SI, CLOSEST, SINK, SOURCE, THRESHOLD, NETWORK, JAMMER = range(8)  # columns of Work.distance


def enter_neighbours(place, heard, t, known_time, known_place):
    """Agents that are heard enter the knowledge with their place and the time."""
    n = known_time.shape[0]
    for v in range(n):
        for u in range(n):
            if heard[v, u]:
                known_time[v, u] = t
                known_place[v, u, 0] = place[u, 0]
                known_place[v, u, 1] = place[u, 1]


def find_roles(i, only_heard, place, sink_estimate, known_time, known_place, heard, role, apart):
    """so, si and c of agent i, among the nodes it knows or only among those it hears now.

    role[3] becomes the node or -1, apart[3] the distance of the closest or -1. A neighbour must be nearer to the source
    (so) or to the sink (si) than the agent; the closest such counts, on ties the lowest index. Less than SLACK is no
    difference.
    """
    n = known_time.shape[0]
    x, y = place[i, 0], place[i, 1]
    source = max(distance(x, y, place[n, 0], place[n, 1]) - SLACK, 0.0)
    sink = max(distance(x, y, sink_estimate[0], sink_estimate[1]) - SLACK, 0.0)
    limit_source, limit_sink = source * source, sink * sink
    for k in range(3):
        role[k] = -1
        apart[k] = -1.0
    for found in range(2):  # first the least distances, then who has them
        for u in range(n + 2):
            if (only_heard and not heard[i, u]) or (u < n and known_time[i, u] < 0):
                continue
            px, py = believed_place(i, u, place, sink_estimate, known_place)
            square = square_distance(x, y, px, py)
            for k in range(3):
                if found == 0 and apart[k] >= 0.0 and square >= apart[k]:
                    continue
                if found == 1 and (role[k] >= 0 or square > apart[k]):
                    continue
                if k == SO and square_distance(px, py, place[n, 0], place[n, 1]) >= limit_source:
                    continue
                if k == SI and square_distance(px, py, sink_estimate[0], sink_estimate[1]) >= limit_sink:
                    continue
                if found == 0:
                    apart[k] = square
                else:
                    role[k] = u
        for k in range(3):
            if apart[k] >= 0.0:
                apart[k] = (math.sqrt(apart[k]) + SLACK) ** 2 if found == 0 else math.sqrt(apart[k]) - SLACK


def believed_place(i, node, place, sink_estimate, known_place):
    """Where agent i believes a node: agents where last heard of, the source where it is, the sink as estimated."""
    n = known_place.shape[0]
    if node < n:
        return known_place[i, node, 0], known_place[i, node, 1]
    if node == n:
        return place[n, 0], place[n, 1]
    return sink_estimate[0], sink_estimate[1]


def measure(i, place, sink_estimate, jammer_range, params, apart):
    """The distances that clauses compare, beside those of the roles; apart[8], -1 where undefined."""
    n = jammer_range.shape[0]
    x, y = place[i, 0], place[i, 1]
    apart[SINK] = distance(x, y, sink_estimate[0], sink_estimate[1])
    apart[SOURCE] = distance(x, y, place[n, 0], place[n, 1])
    apart[THRESHOLD] = params.distance_threshold
    apart[NETWORK] = params.network_range
    apart[JAMMER] = jammer_range[i] if jammer_range[i] > 0.0 else -1.0


def comparisons(left, apart, params):
    """Which comparisons of one left operand hold: bit operator * OPERANDS + right, operators <, >, = in this order.

    Equal means: within one step of motion or the relative tolerance. Nothing holds for an undefined operand.
    """
    bits = 0
    for right in range(OPERANDS):
        operand = apart[right if right < 3 else right + 2]  # so, si, c, threshold, network
        if operand >= 0.0:
            bits |= (left < operand - SLACK) << right
            bits |= (left > operand + SLACK) << (right + OPERANDS)
            equal = abs(left - operand) <= max(params.speed, params.tolerance * operand) + SLACK
            bits |= equal << (right + 2 * OPERANDS)
    return bits


def jammer_comparisons(left, reach, params):
    """As comparisons, with the jammer's range for right operand: bit operator."""
    bits = (left < reach - SLACK) << 0
    bits |= (left > reach + SLACK) << 1
    bits |= (abs(left - reach) <= max(params.speed, params.tolerance * reach) + SLACK) << 2
    return bits


def observe(holding, in_reach, interference, apart, params):
    """Which clauses hold for one agent, as two words: clause k is bit k of the first or bit k - SPLIT of the second.

    interference[3] per channel in mW; apart[8] distances, -1 undefined.
    """
    low = (interference[0] <= params.receive) << NOISE[0]
    low |= 1 << (PACKET_HELD if holding else NO_PACKET_HELD)
    low |= 1 << (NODE_IN_REACH if in_reach else NO_NODE_IN_REACH)
    high = (interference[1] <= params.receive) << (NOISE[1] - SPLIT)
    high |= (interference[2] <= params.receive) << (NOISE[2] - SPLIT)
    for left in (SO, SI, CLOSEST):
        if apart[left] >= 0.0:
            low |= comparisons(apart[left], apart, params) << COMPARE[left]
    for left in (SINK, SOURCE):
        high |= comparisons(apart[left], apart, params) << (COMPARE[left] - SPLIT)
    if apart[JAMMER] >= 0.0:
        for left in range(5):
            if apart[left] >= 0.0:
                high |= jammer_comparisons(apart[left], apart[JAMMER], params) << (COMPARE_JAMMER[left] - SPLIT)
    return low, high


def nearest_obstacle(i, place, agents, world, params):
    """Nearest point of a wall's surface or of another agent within lidar range: (found, x, y); walls first on ties."""
    x, y = place[i, 0], place[i, 1]
    best = (params.lidar_range + SLACK) ** 2
    found, ox, oy = False, 0.0, 0.0
    reach = params.lidar_range + SLACK + params.half_thickness
    for vertical in (True, False):
        walls = world.vertical if vertical else world.horizontal
        across, along = (x, y) if vertical else (y, x)
        for k in range(rank(walls.line, across - reach), walls.line.shape[0]):
            if walls.line[k] > across + reach:
                break
            p, q = nearest_on_wall(walls.line[k], walls.low[k], walls.high[k], params.half_thickness, across, along)
            square = square_distance(p, q, across, along)
            if square < best or (not found and square == best):
                best = square
                found = True
                ox, oy = (p, q) if vertical else (q, p)
    for j in range(agents):
        square = square_distance(place[j, 0], place[j, 1], x, y)
        if j != i and (square < best or (not found and square == best)):
            best = square
            found, ox, oy = True, place[j, 0], place[j, 1]
    return found, ox, oy


def share_knowledge(heard, known_time, known_place, jammer_range, old_time, old_place, old_range):
    """Every agent merges what the agents it hears knew: the newest time wins, and the greatest jammer range.

    All at once: old_* are scratch copies of the knowledge before.
    """
    n = known_time.shape[0]
    for v in range(n):
        old_range[v] = jammer_range[v]
        for w in range(n):
            old_time[v, w] = known_time[v, w]
            old_place[v, w, 0] = known_place[v, w, 0]
            old_place[v, w, 1] = known_place[v, w, 1]
    for v in range(n):
        for u in range(n):
            if not heard[v, u]:
                continue
            jammer_range[v] = max(jammer_range[v], old_range[u])
            for w in range(n):
                if w != v and old_time[u, w] > known_time[v, w]:
                    known_time[v, w] = old_time[u, w]
                    known_place[v, w, 0] = old_place[u, w, 0]
                    known_place[v, w, 1] = old_place[u, w, 1]
