"""Motion: what agents want, and what clearance lets them do (docs/model.md, Agents)."""

from __future__ import annotations

import math

from slcs2_jax.grammar.vocabulary import AWAY, JAMMER, SINK, SOURCE, TOWARD
from tests.oracle.air import is_move
from tests.oracle.geometry import SLACK, crosses, nearest_on_wall, rank, square_distance
from tests.oracle.sensing import believed_place, nearest_obstacle
from tests.oracle.words import DIRECTION, TARGET


def displacement(direction, dx, dy, params):
    """One step with respect to a target at (dx, dy) from the agent: (x, y). None at the target itself."""
    apart = math.sqrt(dx * dx + dy * dy)
    if apart == 0.0:
        return 0.0, 0.0
    if direction == TOWARD:
        length = min(params.speed, max(0.0, apart - params.clearance))
        return dx / apart * length, dy / apart * length
    if direction == AWAY:
        return -dx / apart * params.speed, -dy / apart * params.speed
    chord = min(params.speed, 2.0 * apart)
    ratio = chord / apart
    turned = 1.0 - ratio * ratio / 2.0  # cosine of the angle, counter-clockwise
    sine = ratio * math.sqrt(max(0.0, 1.0 - ratio * ratio / 4.0))
    return dx - turned * dx + sine * dy, dy - sine * dx - turned * dy


def move_target(i, target, role, place, world, params, known_place, jammer_range):
    """Where the target of a move is, as the agent believes: (defined, x, y)."""
    n = jammer_range.shape[0]
    if target < SOURCE:  # so, si or c
        if role[target] < 0:
            return False, 0.0, 0.0
        x, y = believed_place(i, role[target], place, world.sink_estimate, known_place)
        return True, x, y
    if target == SOURCE:
        return True, place[n, 0], place[n, 1]
    if target == SINK:
        return True, world.sink_estimate[0], world.sink_estimate[1]
    if target == JAMMER:
        return jammer_range[i] > 0.0, place[n + 2, 0], place[n + 2, 1]
    return nearest_obstacle(i, place, n, world, params)


def propose(state, world, params, work):
    """step[n, 2] and proposal[n, 2] of every agent; those that do not move propose to stay."""
    n = work.step.shape[0]
    for i in range(n):
        sx, sy = 0.0, 0.0
        if is_move(work.action[i]):
            target, direction = TARGET[work.action[i]], DIRECTION[work.action[i]]
            defined, x, y = move_target(
                i, target, work.role[i], state.place, world, params, state.known_place, state.jammer_range
            )
            if defined:
                sx, sy = displacement(direction, x - state.place[i, 0], y - state.place[i, 1], params)
        work.step[i, 0] = sx
        work.step[i, 1] = sy
        work.proposal[i, 0] = state.place[i, 0] + sx
        work.proposal[i, 1] = state.place[i, 1] + sy


def blocking_wall(walls, across, along, to_across, to_along, params):
    """The nearest wall that forbids to go from one point to another: (square distance, towards it across, along).

    Forbidden: to come nearer to its surface than the clearance, or than now if that is less, and to cross its centre
    line. Square distance -1 if none forbids it.
    """
    nearest, ux, uy = -1.0, 0.0, 0.0
    clear = max(params.clearance - SLACK, 0.0) ** 2
    reach = params.clearance + params.speed + params.half_thickness
    for k in range(rank(walls.line, across - reach), walls.line.shape[0]):
        line, low, high = walls.line[k], walls.low[k], walls.high[k]
        if line > across + reach:
            break
        if along < low - reach or along > high + reach:
            continue
        p, q = nearest_on_wall(line, low, high, params.half_thickness, across, along)
        now = square_distance(p, q, across, along)
        if nearest >= 0.0 and now >= nearest:
            continue
        p2, q2 = nearest_on_wall(line, low, high, params.half_thickness, to_across, to_along)
        then = square_distance(p2, q2, to_across, to_along)
        if then < min(clear, now) or crosses(line, low, high, across, along, to_across, to_along):
            nearest, ux, uy = now, p - across, q - along
    return nearest, ux, uy


def blocking_agent(i, place, others, x, y, params):
    """The nearest of the other agents' points (present places or proposals) that forbids agent i to go to (x, y)."""
    nearest, ux, uy = -1.0, 0.0, 0.0
    clear = max(params.clearance - SLACK, 0.0) ** 2
    for j in range(others.shape[0]):
        then = square_distance(others[j, 0], others[j, 1], x, y)
        if j == i or then >= clear:
            continue
        if then >= square_distance(place[i, 0], place[i, 1], place[j, 0], place[j, 1]):
            continue
        dx, dy = others[j, 0] - place[i, 0], others[j, 1] - place[i, 1]
        now = dx * dx + dy * dy
        if nearest < 0.0 or now < nearest:
            nearest, ux, uy = now, dx, dy
    return nearest, ux, uy


def blocker(i, x, y, state, world, proposal, params):
    """The nearest obstacle that forbids agent i to go to (x, y): (square distance or -1, vector to its nearest point).

    On ties vertical walls come first, then horizontal walls, other agents' places and their proposals.
    """
    n = proposal.shape[0]
    px, py = state.place[i, 0], state.place[i, 1]
    nearest, ux, uy = blocking_wall(world.vertical, px, py, x, y, params)
    square, vy, vx = blocking_wall(world.horizontal, py, px, y, x, params)
    if square >= 0.0 and (nearest < 0.0 or square < nearest):
        nearest, ux, uy = square, vx, vy
    square, vx, vy = blocking_agent(i, state.place, state.place[:n], x, y, params)
    if square >= 0.0 and (nearest < 0.0 or square < nearest):
        nearest, ux, uy = square, vx, vy
    square, vx, vy = blocking_agent(i, state.place, proposal, x, y, params)
    if square >= 0.0 and (nearest < 0.0 or square < nearest):
        nearest, ux, uy = square, vx, vy
    return nearest, ux, uy


def slide(sx, sy, ux, uy, square):
    """The part of a step along the tangent of an obstacle seen in direction u, whose squared length is `square`."""
    along = (sx * ux + sy * uy) / square
    return sx - along * ux, sy - along * uy


def refuse(state, world, params, work):
    """moved[n, 2]: allowed proposals, else the present place; and the tangent candidates of the refused ones."""
    for i in range(work.step.shape[0]):
        work.slides[i] = False
        work.moved[i, 0] = work.proposal[i, 0]
        work.moved[i, 1] = work.proposal[i, 1]
        sx, sy = work.step[i, 0], work.step[i, 1]
        if sx == 0.0 and sy == 0.0:
            continue
        square, ux, uy = blocker(i, work.proposal[i, 0], work.proposal[i, 1], state, world, work.proposal, params)
        if square < 0.0:
            continue
        work.moved[i, 0] = state.place[i, 0]
        work.moved[i, 1] = state.place[i, 1]
        if square > 0.0:
            tx, ty = slide(sx, sy, ux, uy, square)
            work.slides[i] = True
            work.tangent[i, 0] = state.place[i, 0] + tx
            work.tangent[i, 1] = state.place[i, 1] + ty


def meets_slide(i, place, tangent, slides, params):
    """Whether the tangent candidate of agent i comes too near to that of another agent."""
    clear = max(params.clearance - SLACK, 0.0) ** 2
    for j in range(slides.shape[0]):
        if j != i and slides[j]:
            now = square_distance(place[i, 0], place[i, 1], place[j, 0], place[j, 1])
            then = square_distance(tangent[i, 0], tangent[i, 1], tangent[j, 0], tangent[j, 1])
            if then < min(clear, now):
                return True
    return False


def resolve(state, world, params, work):
    """moved[n, 2]: where every agent ends, from step[n, 2] and proposal[n, 2]. All agents move at once."""
    refuse(state, world, params, work)
    for i in range(work.step.shape[0]):
        if not work.slides[i]:
            continue
        x, y = work.tangent[i, 0], work.tangent[i, 1]
        square, _, _ = blocker(i, x, y, state, world, work.proposal, params)
        if square < 0.0 and not meets_slide(i, state.place, work.tangent, work.slides, params):
            work.moved[i, 0] = x
            work.moved[i, 1] = y


def arrive(moved, place):
    """The agents are where they ended."""
    for i in range(moved.shape[0]):
        place[i, 0] = moved[i, 0]
        place[i, 1] = moved[i, 1]
