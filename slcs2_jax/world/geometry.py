"""Axis-aligned walls: which links cross them, how near they are (spec sections 2 and 4).

A wall is a centre line with a thickness. Vertical ones stand at x = ``at`` and span y in [``low``, ``high``]; horizontal
ones are the same with x and y exchanged, so every function is written once, for vertical walls.
The loops run over blocks of walls, unrolled: every link or agent stays in registers while a block passes by, which
compiles to plain vector code on CPU and GPU; a reduction over the wall axis would not.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np

BLOCK = 16  # walls per unrolled block; capacities are multiples of it

Carry = TypeVar("Carry")


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Lines:
    """Parallel walls. ``at``, ``low``, ``high``: float32 [V, ...], m; rows with low > high are padding."""

    at: jax.Array
    low: jax.Array
    high: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Walls:
    """All walls of a scenario."""

    vertical: Lines
    horizontal: Lines


Body = Callable[[Carry, jax.Array, jax.Array, jax.Array], Carry]


def fold(lines: Lines, body: Body, carry: Carry) -> Carry:
    """Apply ``body(carry, at, low, high)`` to every wall in turn, in blocks of ``BLOCK``.

    Args:
        lines: walls [V, ...], V a multiple of ``BLOCK``.
        body: one wall's contribution; at, low, high have shape [...].
        carry: any pytree.
    """
    count = lines.at.shape[0]
    if count == 0:
        return carry

    def block(carry: Carry, walls: Lines) -> tuple[Carry, None]:
        for k in range(BLOCK):
            carry = body(carry, walls.at[k], walls.low[k], walls.high[k])
        return carry, None

    blocks = jax.tree.map(lambda a: a.reshape(count // BLOCK, BLOCK, *a.shape[1:]), lines)
    return jax.lax.scan(block, carry, blocks)[0]


def crosses(
    x1: jax.Array, y1: jax.Array, x2: jax.Array, slope: jax.Array, at: jax.Array, low: jax.Array, high: jax.Array
) -> jax.Array:
    """Whether the segment from (x1, y1) to x2 with the given slope crosses a vertical centre line: bool [...]."""
    height = y1 + (at - x1) * slope
    return ((x1 < at) != (x2 < at)) & (height >= low) & (height <= high)


def slope(x1: jax.Array, y1: jax.Array, x2: jax.Array, y2: jax.Array) -> jax.Array:
    """Rise of a segment per metre of x; 0 for a vertical one, which crosses no vertical wall anyway."""
    run = x2 - x1
    return jnp.where(run == 0, np.float32(0), (y2 - y1) / jnp.where(run == 0, np.float32(1), run))


def _crossings(x1: jax.Array, y1: jax.Array, x2: jax.Array, y2: jax.Array, lines: Lines) -> jax.Array:
    rise = slope(x1, y1, x2, y2)

    def body(count: jax.Array, at: jax.Array, low: jax.Array, high: jax.Array) -> jax.Array:
        return count + crosses(x1, y1, x2, rise, at, low, high).astype(jnp.float32)

    return fold(lines, body, jnp.zeros_like(x1))


def count_crossings(x1: jax.Array, y1: jax.Array, x2: jax.Array, y2: jax.Array, walls: Walls) -> jax.Array:
    """How many walls' centre lines each segment crosses (spec 3, ``walls(i, j)``): float32, shape of ``x1`` [P, ...]."""
    return _crossings(x1, y1, x2, y2, walls.vertical) + _crossings(y1, x1, y2, x2, walls.horizontal)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Nearest:
    """The nearest point of something: squared distance (m2, inf if there is none) and the point (m)."""

    squared: jax.Array
    x: jax.Array
    y: jax.Array

    @classmethod
    def none(cls, like: jax.Array) -> Nearest:
        """Nothing seen yet, shaped as ``like``."""
        return cls(jnp.full_like(like, jnp.inf), jnp.zeros_like(like), jnp.zeros_like(like))

    def or_nearer(
        self, squared: jax.Array, x: jax.Array, y: jax.Array, valid: jax.Array | bool = True
    ) -> Nearest:
        """Replace by a candidate where it is valid and strictly nearer: the first of equals stays."""
        nearer = valid & (squared < self.squared)
        pick = jax.tree_util.Partial(jnp.where, nearer)
        return Nearest(pick(squared, self.squared), pick(x, self.x), pick(y, self.y))


def surface_point(
    x: jax.Array, y: jax.Array, at: jax.Array, low: jax.Array, high: jax.Array, half: jax.Array
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Nearest point of a vertical wall's rectangle: (squared distance, x, y), shapes of ``x``."""
    px = jnp.clip(x, at - half, at + half)
    py = jnp.clip(y, low, high)
    return (px - x) ** 2 + (py - y) ** 2, px, py


def nearest_wall(x: jax.Array, y: jax.Array, half: jax.Array, walls: Walls) -> Nearest:
    """The nearest point of any wall's surface, vertical walls first on ties: shapes of ``x`` [n, ...].

    ``half``: half the walls' thickness, m, scalar.
    """

    def vertical(best: Nearest, at: jax.Array, low: jax.Array, high: jax.Array) -> Nearest:
        squared, px, py = surface_point(x, y, at, low, high, half)
        return best.or_nearer(squared, px, py, low <= high)

    def horizontal(best: Nearest, at: jax.Array, low: jax.Array, high: jax.Array) -> Nearest:
        squared, py, px = surface_point(y, x, at, low, high, half)
        return best.or_nearer(squared, px, py, low <= high)

    return fold(walls.horizontal, horizontal, fold(walls.vertical, vertical, Nearest.none(x)))


def blocking_wall(
    x: jax.Array,
    y: jax.Array,
    to_x: jax.Array,
    to_y: jax.Array,
    clearance: jax.Array,
    half: jax.Array,
    walls: Walls,
) -> Nearest:
    """The nearest point, seen from (x, y), of the walls that forbid a step to (to_x, to_y) (spec 4).

    A wall forbids the step if it ends nearer to the wall's surface than the clearance and than it began, or if it crosses
    the wall's centre line.

    Args:
        x, y, to_x, to_y: float32 [n, ...], m.
        clearance, half: m, scalars: the clearance and half the walls' thickness.
        walls: the walls.

    Returns:
        Nearest [n, ...]; squared distance inf where the step is allowed.
    """
    limit = clearance * clearance

    def side(x: jax.Array, y: jax.Array, to_x: jax.Array, to_y: jax.Array, swapped: bool) -> Body:
        rise = slope(x, y, to_x, to_y)

        def body(best: Nearest, at: jax.Array, low: jax.Array, high: jax.Array) -> Nearest:
            before, px, py = surface_point(x, y, at, low, high, half)
            after, _, _ = surface_point(to_x, to_y, at, low, high, half)
            forbids = (after < jnp.minimum(limit, before)) | crosses(x, y, to_x, rise, at, low, high)
            point = (py, px) if swapped else (px, py)
            return best.or_nearer(before, *point, forbids & (low <= high))

        return body

    best = fold(walls.vertical, side(x, y, to_x, to_y, False), Nearest.none(x))
    return fold(walls.horizontal, side(y, x, to_y, to_x, True), best)
