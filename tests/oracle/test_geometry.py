"""Walls: crossings and distances, against shapely."""

import numpy as np
import pytest
import shapely

from tests.oracle import geometry, inputs


def test_rank_counts_lines_at_or_below():
    line = np.array([1.0, 2.0, 2.0, 5.0])
    assert [geometry.rank(line, c) for c in (0.0, 1.0, 2.0, 4.9, 5.0, 9.0)] == [0, 1, 3, 3, 4, 4]


@pytest.mark.parametrize(
    ("ends", "walls"),
    [
        ((0, 0, 10, 0), 2),  # both lines in between, within their extent
        ((10, 0, 0, 0), 2),  # reciprocal
        ((0, 0, 4, 0), 0),  # stops short
        ((0, 6, 10, 6), 0),  # passes above
        ((5, -1, 5, 1), 0),  # runs along the first line
        ((0, 5, 10, 5), 1),  # touches the end of the first; the second is shorter
        ((5, 0, 10, 0), 1),  # an end on the line counts as beyond it
    ],
)
def test_crossings_of_two_vertical_walls(ends, walls):
    table = inputs.make_walls([(7, -1, 1), (5, -5, 5)])
    assert geometry.crossings(table, *map(float, ends)) == walls


def test_crossings_agree_with_shapely():
    rng = np.random.default_rng(5)
    rows = np.sort(rng.uniform(-50, 50, (30, 3)), axis=1)[:, [1, 0, 2]]
    walls = inputs.make_walls(rows)
    lines = shapely.linestrings([[(c, a), (c, b)] for c, a, b in rows])
    for x1, y1, x2, y2 in rng.uniform(-60, 60, (200, 4)):
        expected = shapely.intersects(lines, shapely.LineString([(x1, y1), (x2, y2)])).sum()
        assert geometry.crossings(walls, x1, y1, x2, y2) == expected
        assert sum(geometry.crosses(c, a, b, x1, y1, x2, y2) for c, a, b in rows) == expected


def test_nearest_point_of_a_wall_agrees_with_shapely():
    box = shapely.box(2.5, -4.0, 3.5, 6.0)
    for x, y in np.random.default_rng(6).uniform(-10, 10, (200, 2)):
        px, py = geometry.nearest_on_wall(3.0, -4.0, 6.0, 0.5, x, y)
        assert geometry.distance(px, py, x, y) == pytest.approx(box.distance(shapely.Point(x, y)), abs=1e-12)
