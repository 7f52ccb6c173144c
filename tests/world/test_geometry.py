"""Walls against shapely: crossed links, nearest points of surfaces, and forbidden steps."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from slcs2_jax.world import geometry
from slcs2_jax.world.geometry import Lines, Walls

HALF = 0.5
MARGIN = 1e-3  # m: nearer to a decision than this, single precision may decide otherwise than shapely

count_crossings = jax.jit(geometry.count_crossings)
nearest_wall = jax.jit(geometry.nearest_wall)
blocking_wall = jax.jit(geometry.blocking_wall)
CLEAR = np.float32(2.0**2)  # m2


def lines(rows, capacity=None):
    """Rows (at, low, high) padded to whole blocks."""
    rows = np.asarray(rows, np.float32).reshape(-1, 3)
    capacity = -(-len(rows) // geometry.BLOCK) * geometry.BLOCK if capacity is None else capacity
    table = np.tile(np.array([1e6, 1, -1], np.float32), (capacity, 1))
    table[: len(rows)] = rows
    return Lines(*(jnp.asarray(column) for column in table.T))


def walls(vertical=(), horizontal=(), capacity=None):
    return Walls(lines(vertical, capacity), lines(horizontal, capacity))


def few(vertical=(), horizontal=()):
    """A handful of walls: one block each way, so that the worked cases share their compiled programs."""
    return walls(vertical, horizontal, geometry.BLOCK)


def random_rows(rng, count, size=100.0):
    low = rng.uniform(0, size, count)
    return np.stack([rng.uniform(0, size, count), low, low + rng.uniform(2, 30, count)], axis=1).astype(np.float32)


def floats(*arrays):
    """Places are [n, ...]: numbers become arrays of one."""
    return tuple(jnp.atleast_1d(jnp.asarray(a, jnp.float32)) for a in arrays)


def centre_lines(vertical, horizontal):
    v = [shapely.LineString([(x, a), (x, b)]) for x, a, b in vertical.astype(float)]
    h = [shapely.LineString([(a, y), (b, y)]) for y, a, b in horizontal.astype(float)]
    return np.array(v + h)


def rectangles(vertical, horizontal, half=HALF):
    v = [shapely.box(x - half, a, x + half, b) for x, a, b in vertical.astype(float)]
    h = [shapely.box(a, y - half, b, y + half) for y, a, b in horizontal.astype(float)]
    return np.array(v + h)


def segments(x1, y1, x2, y2):
    return shapely.linestrings(np.stack([np.stack([x1, y1], -1), np.stack([x2, y2], -1)], axis=-2).astype(float))


@pytest.fixture(scope="module")
def town():
    rng = np.random.default_rng(1)
    vertical, horizontal = random_rows(rng, 40), random_rows(rng, 25)
    return vertical, horizontal, walls(vertical, horizontal)


def test_crossings_are_shapelys(town):
    vertical, horizontal, built = town
    ends = np.random.default_rng(2).uniform(-20, 120, (4, 6000)).astype(np.float32)
    links, centres = segments(*ends), centre_lines(vertical, horizontal)
    expected = shapely.intersects(links[:, None], centres).sum(axis=1)
    corners = shapely.points(np.array([c for line in centres for c in line.coords]))
    tips = shapely.get_coordinates(links).reshape(-1, 2, 2)
    clear = shapely.distance(links[:, None], corners).min(axis=1) > MARGIN
    clear &= (shapely.distance(shapely.points(tips)[..., None], centres) > MARGIN).all(axis=(1, 2))
    assert clear.mean() > 0.95
    np.testing.assert_array_equal(np.asarray(count_crossings(*floats(*ends), built))[clear], expected[clear])
    assert expected.max() > 5


def test_crossings_are_reciprocal_exactly(town):
    ends = floats(*np.random.default_rng(3).uniform(0, 100, (4, 4000)))
    there = np.asarray(count_crossings(*ends, town[2]))
    back = np.asarray(count_crossings(ends[2], ends[3], ends[0], ends[1], town[2]))
    assert (there != back).mean() < 1e-3  # the height is computed from the other end, and may round otherwise


@pytest.mark.parametrize(
    ("link", "expected"),
    [
        ((0, 5, 20, 5), 1),  # through the vertical wall
        ((0, 5, 9.9, 5), 0),  # short of it
        ((0, 15, 20, 15), 0),  # past its end
        ((0, 0, 20, 20), 1),  # through its upper end: the end belongs to it
        ((3, -5, 3, 5), 0),  # along y, beside it
        ((10, -5, 10, 25), 0),  # along it, in its centre line
        ((30, 20, 30, 40), 1),  # along y through the horizontal wall
        ((0, 30, 60, 30), 0),  # along the horizontal wall's centre line
        ((0, 5, 35, 40), 1),  # slantwise, past the vertical, through the horizontal at (25, 30)
        ((5, 5, 5, 5), 0),  # a point
    ],
)
def test_crossings_by_hand(link, expected):
    built = few([(10, 0, 10)], [(30, 20, 50)])
    assert count_crossings(*floats(*link), built)[0] == expected


def test_a_link_that_ends_on_a_centre_line_crosses_it_from_one_side_only():
    built = few([(10, 0, 10)])
    sides = [int(count_crossings(*floats(x, 5, 10, 5), built)[0]) for x in (0, 20)]
    assert sorted(sides) == [0, 1]  # so that a path through the wall in two pieces crosses it once


def test_overlapping_walls_count_each():
    built = few([(10, 0, 10)] * 3 + [(11, 0, 10)])
    assert count_crossings(*floats(0, 5, 20, 5), built)[0] == 4


@pytest.mark.parametrize("capacity", [0, geometry.BLOCK])
def test_padding_and_no_walls_at_all_change_nothing(capacity):
    built = walls(capacity=capacity)
    x, y, other, far = floats(np.linspace(-5, 5, 4), np.zeros(4), np.linspace(0, 2e6, 4), np.full(4, 3e6))
    assert (np.asarray(count_crossings(x, y, other, far, built)) == 0).all()
    assert np.isinf(nearest_wall(x, y, np.float32(HALF), built).squared).all()
    step = blocking_wall(x, y, other, far, CLEAR, np.float32(HALF), built)
    assert np.isinf(step.squared).all()


def test_nearest_points_are_shapelys(town):
    vertical, horizontal, built = town
    x, y = np.random.default_rng(4).uniform(-20, 140, (2, 4000)).astype(np.float32)
    found = jax.device_get(nearest_wall(*floats(x, y), np.float32(HALF), built))
    points = shapely.points(x.astype(float), y.astype(float))
    apart = shapely.distance(points[:, None], rectangles(vertical, horizontal))
    np.testing.assert_allclose(np.sqrt(found.squared), apart.min(axis=1), atol=1e-4)
    np.testing.assert_allclose(np.hypot(found.x - x, found.y - y), apart.min(axis=1), atol=1e-4)
    surface = shapely.distance(shapely.points(found.x.astype(float), found.y.astype(float))[:, None],
                               rectangles(vertical, horizontal))  # fmt: skip
    assert surface.min(axis=1).max() < 1e-4
    assert (apart.min(axis=1) == 0).sum() > 50  # inside a wall, too


def test_a_wall_has_its_thickness_at_its_sides_and_none_beyond_its_ends():
    built = few([(10, 0, 20)])
    x, y = floats([5, 15, 10, 13], [10, 10, 25, 24])
    found = nearest_wall(x, y, np.float32(HALF), built)
    np.testing.assert_allclose(found.x, [9.5, 10.5, 10, 10.5])
    np.testing.assert_allclose(found.y, [10, 10, 20, 20])
    np.testing.assert_allclose(found.squared, [4.5**2, 4.5**2, 25, 2.5**2 + 16])


def test_vertical_walls_come_first_on_ties_and_then_the_first_of_equals():
    built = few([(10, -5, 5), (-10, -5, 5)], [(10, -5, 5)])
    found = nearest_wall(*floats(0, 0), np.float32(HALF), built)
    assert (found.x[0], found.y[0]) == (9.5, 0)


def forbidding(vertical, horizontal, x, y, to_x, to_y, clearance):
    """For each step and wall, whether the wall forbids it, and its distance before; and which steps are clear cases."""
    solid = rectangles(vertical, horizontal)
    before, after = (
        shapely.distance(shapely.points(a.astype(float), b.astype(float))[:, None], solid)
        for a, b in ((x, y), (to_x, to_y))
    )
    steps, centres = segments(x, y, to_x, to_y), centre_lines(vertical, horizontal)
    crosses = shapely.intersects(steps[:, None], centres)
    least = np.minimum(clearance, before)
    forbids = (after < least) | crosses
    corners = shapely.points(np.array([c for line in centres for c in line.coords]))
    clear = (np.abs(after - least) > MARGIN).all(axis=1) | ((after == 0) & (before == 0)).any(axis=1)
    clear &= shapely.distance(steps[:, None], corners).min(axis=1) > MARGIN
    clear &= (shapely.distance(shapely.points(x.astype(float), y.astype(float))[:, None], centres) > MARGIN).all(axis=1)
    clear &= (shapely.distance(shapely.points(to_x.astype(float), to_y.astype(float))[:, None], centres) > MARGIN).all(
        axis=1
    )
    return forbids, before, clear


@pytest.mark.parametrize("clearance", [2.0, 0.3])
def test_forbidden_steps_are_shapelys(town, clearance):
    vertical, horizontal, built = town
    rng = np.random.default_rng(5)
    x, y = rng.uniform(0, 130, (2, 4000)).astype(np.float32)
    angle, length = rng.uniform(0, 2 * np.pi, 4000), rng.uniform(0, 6, 4000)
    to_x, to_y = (x + length * np.cos(angle)).astype(np.float32), (y + length * np.sin(angle)).astype(np.float32)
    found = jax.device_get(blocking_wall(*floats(x, y, to_x, to_y), np.float32(clearance**2), np.float32(HALF), built))
    forbids, before, clear = forbidding(vertical, horizontal, x, y, to_x, to_y, clearance)
    refused = forbids.any(axis=1)
    assert clear.mean() > 0.9
    assert 0.1 < refused[clear].mean() < 0.9
    np.testing.assert_array_equal(np.isfinite(found.squared)[clear], refused[clear])
    nearest = np.where(forbids, before, np.inf).min(axis=1)
    both = clear & refused
    np.testing.assert_allclose(np.sqrt(found.squared[both]), nearest[both], atol=1e-4)
    np.testing.assert_allclose(np.hypot(found.x - x, found.y - y)[both], nearest[both], atol=1e-4)


@pytest.mark.parametrize(
    ("start", "end", "forbidden"),
    [
        ((5, 5), (7, 5), False),  # 2.5 m are left
        ((5, 5), (7.5, 5), False),  # exactly the clearance is left
        ((5, 5), (7.6, 5), True),  # less
        ((8, 5), (8, 6), False),  # nearer than the clearance already, but no nearer
        ((8, 5), (7, 5), False),  # and farther
        ((8, 5), (8.1, 5), True),  # and nearer
        ((8, 5), (8, 5), False),  # staying is always allowed
        ((5, 5), (15, 5), True),  # through the wall to a place that is clear
        ((5, 5), (15, 25), False),  # past its end
    ],
)
def test_forbidden_steps_by_hand(start, end, forbidden):
    built = few([(10, 0, 10)])
    found = blocking_wall(*floats(*start, *end), CLEAR, np.float32(HALF), built)
    assert bool(np.isfinite(found.squared[0])) == forbidden
    turned = few(horizontal=[(10, 0, 10)])
    found = blocking_wall(*floats(*start[::-1], *end[::-1]), CLEAR, np.float32(HALF), turned)
    assert bool(np.isfinite(found.squared[0])) == forbidden


def test_the_nearest_of_several_forbidding_walls_is_told():
    built = few([(10, -5, 5)], [(4, -5, 12)])
    found = blocking_wall(*floats(0, 0, 9, 3), CLEAR, np.float32(HALF), built)
    assert (found.x[0], found.y[0]) == (0, 3.5)
    found = blocking_wall(*floats(0, 0, 9, 0), CLEAR, np.float32(HALF), built)
    assert (found.x[0], found.y[0]) == (9.5, 0)  # the other is nearer, but forbids nothing


def test_the_point_told_is_as_far_as_the_distance_told_whatever_the_program(town):
    """Distance and point come out of passes that a compiler may round differently; they must tell of the same wall."""
    vertical, horizontal, _ = town
    built = walls(vertical[:16], horizontal[:16])
    rng = np.random.default_rng(7)
    x, y = floats(*rng.uniform(0, 130, (2, 12, 64)))
    step = floats(*rng.uniform(-2, 2, (2, 12, 64)))
    batch = jax.tree.map(lambda a: jnp.broadcast_to(a[:, None], (*a.shape, 64)), built)

    def mismatch(found, x, y):
        apart = (found.x - x) ** 2 + (found.y - y) ** 2
        share = jnp.abs(apart - found.squared) / (1 + found.squared)
        return jnp.max(jnp.where(jnp.isfinite(found.squared), share, np.float32(0)))

    @jax.jit
    def walk(x, y):
        def body(place, _):
            to = (place[0] + step[0], place[1] + step[1])
            near = geometry.nearest_wall(*place, np.float32(HALF), batch)
            block = geometry.blocking_wall(*place, *to, CLEAR, np.float32(HALF), batch)
            return to, jnp.stack([mismatch(near, *place), mismatch(block, *place)])

        return jax.lax.scan(body, (x, y), length=20)[1]

    assert np.asarray(walk(x, y)).max() < 1e-4


def test_batches_have_walls_of_their_own(town):
    vertical, horizontal, _ = town
    rng = np.random.default_rng(6)
    ends = floats(*rng.uniform(0, 100, (4, 50, 3)))
    per_batch = [walls(vertical[k:], horizontal[k:], capacity=48) for k in (0, 10, 20)]
    stacked = jax.tree.map(lambda *a: jnp.stack(a, axis=-1), *per_batch)
    together = np.asarray(count_crossings(*ends, stacked))
    for b, one in enumerate(per_batch):
        np.testing.assert_array_equal(together[:, b], count_crossings(*(e[:, b] for e in ends), one))
