"""Distances and axis-aligned walls.

Of a wall's two coordinates `across` is the one its centre line keeps (x for a vertical wall) and `along` the other;
a function written for vertical walls serves horizontal ones with x and y exchanged.
"""

from __future__ import annotations

import math

SLACK = 1e-3  # m: what is nearer to a limit than this meets it, so that rounding decides nothing


def square_distance(x1, y1, x2, y2):
    """Squared distance of two points."""
    return (x1 - x2) * (x1 - x2) + (y1 - y2) * (y1 - y2)


def distance(x1, y1, x2, y2):
    """Distance of two points."""
    return math.sqrt(square_distance(x1, y1, x2, y2))


def rank(line, across):
    """How many of the sorted centre lines lie at or below the coordinate: the index of the first one above."""
    first, last = 0, line.shape[0]
    while first < last:
        middle = (first + last) // 2
        if across < line[middle]:
            last = middle
        else:
            first = middle + 1
    return first


def crossings(walls, across1, along1, across2, along2):
    """How many walls the straight line between two points crosses.

    The walls between the ranks of the ends are exactly those with (end 1 < line) != (end 2 < line).
    """
    if walls.line.shape[0] == 0:
        return 0
    first, last = rank(walls.line, across1), rank(walls.line, across2)
    if first == last:
        return 0
    if last < first:
        first, last = last, first
    slope = (along2 - along1) / (across2 - across1)
    count = 0
    for k in range(first, last):
        meets = along1 + (walls.line[k] - across1) * slope
        count += walls.low[k] <= meets and meets <= walls.high[k]
    return count


def crosses(line, low, high, across1, along1, across2, along2):
    """Whether the segment between two points crosses one wall's centre line."""
    if (across1 < line) == (across2 < line):
        return False
    meets = along1 + (line - across1) * (along2 - along1) / (across2 - across1)
    return low <= meets and meets <= high


def nearest_on_wall(line, low, high, half_thickness, across, along):
    """The point of the wall's rectangle nearest to a point: (across, along)."""
    return (
        min(max(across, line - half_thickness), line + half_thickness),
        min(max(along, low), high),
    )
