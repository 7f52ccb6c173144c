"""Axis-aligned walls: which links cross them, how near they are (model sections 2 and 4).

A wall is a centre line with a thickness. Vertical ones stand at x = ``at`` and span y in [``low``, ``high``];
horizontal ones are the same with x and y exchanged, so every function is written once, for vertical walls.
Walls are the leftmost axis, so that reducing over it leaves the vector lanes to the batch. Links are many: their counts
stay in registers while blocks of walls pass by; a plain reduction would store every pair of wall and link.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.world.stored import stored

_INFINITY = np.float32(np.inf).view(np.uint32)
BLOCK = 16  # walls per block; the capacity for walls is a multiple of it
SLACK = 1e-3  # m: what is nearer to a limit than this meets it, so that rounding decides nothing


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Lines:
    """Parallel walls. ``at``, ``low``, ``high``: float32 [V, ...], m, V a multiple of BLOCK.

    Padding has low > high, and stands so far away that its squared distance is infinite.
    """

    at: jax.Array
    low: jax.Array
    high: jax.Array


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Walls:
    """All walls of a scenario."""

    vertical: Lines
    horizontal: Lines


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


def count_crossings(x1: jax.Array, y1: jax.Array, x2: jax.Array, y2: jax.Array, walls: Walls) -> jax.Array:
    """How many walls' centre lines each segment crosses (model 3, ``walls(i, j)``): float32, shape of ``x1``."""
    return (_crossings(x1, y1, x2, y2, walls.vertical) + _crossings(y1, x1, y2, x2, walls.horizontal)).astype(
        jnp.float32
    )


def _crossings(x1: jax.Array, y1: jax.Array, x2: jax.Array, y2: jax.Array, lines: Lines) -> jax.Array:
    rise = slope(x1, y1, x2, y2)

    if lines.at.shape[0] == 0:
        return jnp.zeros(x1.shape, jnp.int32)

    def block(count: jax.Array, walls: Lines) -> tuple[jax.Array, None]:
        for k in range(BLOCK):
            count = count + crosses(x1, y1, x2, rise, walls.at[k], walls.low[k], walls.high[k]).astype(jnp.int32)
        return count, None

    def in_blocks(lines: Lines) -> jax.Array:
        blocks = jax.tree.map(lambda a: a.reshape(-1, BLOCK, *a.shape[1:]), lines)
        return jax.lax.scan(block, jnp.zeros(x1.shape, jnp.int32), blocks)[0]

    def at_once(lines: Lines) -> jax.Array:
        walls = jax.tree.map(partial(_against, x1), lines)
        crossed = crosses(x1, y1, x2, rise, walls.at, walls.low, walls.high)
        return jnp.sum(crossed, axis=0, dtype=np.min_scalar_type(lines.at.shape[0])).astype(jnp.int32)

    return jax.lax.platform_dependent(lines, cpu=in_blocks, default=at_once)


def _against(places: jax.Array, walls: jax.Array) -> jax.Array:
    """Walls [V, ...] as [V, 1, ...], to be spread over places [n, ...] or links [m, n, ...]."""
    return walls.reshape(walls.shape[0], *(1,) * (places.ndim - walls.ndim + 1), *walls.shape[1:])


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

    def or_nearer(self, squared: jax.Array, x: jax.Array, y: jax.Array, valid: jax.Array | bool = True) -> Nearest:
        """Replace by a candidate where it is valid and strictly nearer: the first of equals stays."""
        nearer = valid & (squared < self.squared)
        pick = jax.tree_util.Partial(jnp.where, nearer)
        return Nearest(pick(squared, self.squared), pick(x, self.x), pick(y, self.y))


def nearest_wall(x: jax.Array, y: jax.Array, half: jax.Array, walls: Walls) -> Nearest:
    """The nearest point of any wall's surface, vertical walls first on ties: shapes of ``x`` [n, ...].

    ``half``: half the walls' thickness, m, scalar.
    """
    vertical = _nearest(x, y, half, walls.vertical, lambda *_: True)
    horizontal = _nearest(y, x, half, walls.horizontal, lambda *_: True)
    return vertical.or_nearer(horizontal.squared, horizontal.y, horizontal.x)


def blocking_wall(
    x: jax.Array,
    y: jax.Array,
    to_x: jax.Array,
    to_y: jax.Array,
    limit: jax.Array,
    half: jax.Array,
    walls: Walls,
) -> Nearest:
    """The nearest point, seen from (x, y), of the walls that forbid a step to (to_x, to_y) (model 4).

    A wall forbids the step if it ends nearer to the wall's surface than the limit and than it began, or if it crosses
    the wall's centre line.

    Args:
        x, y, to_x, to_y: float32 [n, ...], m.
        limit: m2, scalar, the squared distance that is always far enough.
        half: m, scalar, half the walls' thickness.
        walls: the walls.

    Returns:
        Nearest [n, ...]; squared distance inf where the step is allowed.
    """

    def side(x: jax.Array, y: jax.Array, to_x: jax.Array, to_y: jax.Array, lines: Lines) -> Nearest:
        rise = slope(x, y, to_x, to_y)

        def forbids(before: jax.Array, at: jax.Array, low: jax.Array, high: jax.Array) -> jax.Array:
            after = _squared(to_x, to_y, half, at, low, high)
            return (after < jnp.minimum(limit, before)) | crosses(x, y, to_x, rise, at, low, high)

        return _nearest(x, y, half, lines, forbids)

    vertical = side(x, y, to_x, to_y, walls.vertical)
    horizontal = side(y, x, to_y, to_x, walls.horizontal)
    return vertical.or_nearer(horizontal.squared, horizontal.y, horizontal.x)


def _squared(x: jax.Array, y: jax.Array, half: jax.Array, at: jax.Array, low: jax.Array, high: jax.Array) -> jax.Array:
    """Squared distance of places to vertical walls' surfaces, m2; inf for padding."""
    across = jnp.maximum(jnp.abs(x - at) - half, np.float32(0))
    along = jnp.maximum(jnp.maximum(low - y, y - high), np.float32(0))
    squared = across * across + along * along

    def checked(squared: jax.Array, low: jax.Array, high: jax.Array) -> jax.Array:
        return jnp.where(low <= high, squared, jnp.inf)

    # Padding is so far away that its squared distance is infinite anyway. To test for it makes GPUs read more; without
    # the test the CPU's compiler would round the sum in another way, and results would change.
    return jax.lax.platform_dependent(squared, low, high, cpu=checked, default=lambda squared, *_: squared)


def _nearest(
    x: jax.Array, y: jax.Array, half: jax.Array, lines: Lines, counts: Callable[..., jax.Array | bool]
) -> Nearest:
    """The nearest surface point of those vertical walls that count, the first of equals.

    ``counts(squared, at, low, high)`` tells which do, for walls [V, 1, ...] against places [n, ...].
    """
    walls = lines.at.shape[0]
    if walls == 0:
        return Nearest.none(x)
    at, low, high = (_against(x, a) for a in (lines.at, lines.low, lines.high))
    squared = _squared(x, y, half, at, low, high)
    squared = jnp.where(counts(squared, at, low, high), squared, jnp.inf)
    # One minimum over words whose high bits are the distance's and whose low bits are the wall's number. Distances that
    # these bits do not tell apart differ by less than SLACK at any range of the lidar: the first is taken.
    low_bits = np.uint32((1 << (walls - 1).bit_length()) - 1)
    number = stored(jnp.arange(walls, dtype=jnp.uint32), half).reshape(walls, *(1,) * x.ndim)
    ticket = jax.lax.bitcast_convert_type(squared, jnp.uint32) & ~low_bits | number

    def gathered(ticket: jax.Array, lines: Lines) -> tuple[jax.Array, ...]:
        least = jnp.min(ticket, axis=0)
        first = (least & low_bits).astype(jnp.int32)
        return least, *(jnp.take_along_axis(a, first, axis=0) for a in (lines.at, lines.low, lines.high))

    def summed(ticket: jax.Array, lines: Lines) -> tuple[jax.Array, ...]:
        least = jnp.min(ticket, axis=0)
        first = number == (least & low_bits)
        return least, *(jnp.sum(jnp.where(first, a, np.float32(0)), axis=0) for a in (at, low, high))

    # The wall of the least ticket, looked up; or summed up, since GPUs would turn the tables round for a look-up.
    least, at, low, high = jax.lax.platform_dependent(ticket, lines, cpu=gathered, default=summed)
    none = least >= _INFINITY
    best = jnp.where(none, jnp.inf, _squared(x, y, half, at, low, high))
    return Nearest(best, jnp.clip(x, at - half, at + half), jnp.clip(y, low, high))
