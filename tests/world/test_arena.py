"""Scenarios stacked for the device."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from slcs2_jax.config import Settings, Swarm, World
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.geometry import BLOCK
from slcs2_jax.world.scenario import make_scenario

KINDS = ("open", "jammed", "urban", "urban_jammed")


@pytest.fixture(scope="module")
def scenarios():
    return [
        make_scenario(Settings(world=World.preset(kind, reach), swarm=Swarm(agents=5, sink_error=3.0)), seed)
        for seed, (kind, reach) in enumerate((k, r) for k in KINDS for r in ("short", "long"))
    ]


@pytest.fixture(scope="module")
def arena(scenarios):
    channels = [(0,), (0, 1, 2), (1,), (2,), (0,), (1, 2), (0,), (0, 1, 2)]
    return stack(scenarios, channels, capacity=wall_capacity(scenarios), width=3)


def test_everything_stands_in_its_column(scenarios, arena):
    for b, s in enumerate(scenarios):
        assert (arena.sink_x[b], arena.sink_y[b]) == tuple(s.sink)
        assert (arena.estimate_x[b], arena.estimate_y[b]) == tuple(s.sink_estimate)
        np.testing.assert_array_equal(arena.start_x[:, b], s.start[:, 0])
        np.testing.assert_array_equal(arena.start_y[:, b], s.start[:, 1])
        assert arena.time_limit[b] == s.time_limit
        assert arena.has_jammer[b] == (s.jammer is not None)
        if s.jammer is not None:
            assert (arena.jammer_x[b], arena.jammer_y[b]) == tuple(s.jammer)


def test_walls_come_first_and_padding_meets_nothing(scenarios, arena):
    for side in ("vertical", "horizontal"):
        lines = getattr(arena.walls, side)
        for b, s in enumerate(scenarios):
            rows = getattr(s, side)
            np.testing.assert_array_equal(np.stack([lines.at, lines.low, lines.high], -1)[: len(rows), b], rows)
            assert (lines.low[len(rows) :, b] > lines.high[len(rows) :, b]).all()


def test_a_world_without_a_jammer_parks_it_out_of_everybodys_reach(scenarios, arena):
    for b, s in enumerate(scenarios):
        if s.jammer is None:
            assert np.hypot(arena.jammer_x[b], arena.jammer_y[b]) > 1e5


def test_the_channels_of_each_grammar(arena):
    expected = [[1, 0, 0], [1, 1, 1], [0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 1, 1], [1, 0, 0], [1, 1, 1]]
    np.testing.assert_array_equal(arena.channels.T, np.array(expected, bool))


def test_dtypes_and_the_batch_last(arena):
    assert arena.time_limit.dtype == np.int32
    assert arena.channels.dtype == arena.has_jammer.dtype == np.bool_
    for leaf in jax.tree.leaves(arena):
        assert leaf.shape[-1] == 8
        assert leaf.dtype in (np.float32, np.int32, np.bool_)


def test_capacity_is_enough_and_in_whole_blocks(scenarios):
    vertical, horizontal = wall_capacity(scenarios)
    for need, got in (
        (max(len(s.vertical) for s in scenarios), vertical),
        (max(len(s.horizontal) for s in scenarios), horizontal),
    ):
        assert need <= got < need + BLOCK
        assert got % BLOCK == 0


def test_no_walls_need_no_room(scenarios):
    assert wall_capacity(scenarios[:2]) == (0, 0)
    assert wall_capacity([]) == (0, 0)
    bare = stack(scenarios[:2], [(0,), (0,)], capacity=(0, 0), width=1)
    assert bare.walls.vertical.at.shape == (0, 2)


def test_more_capacity_than_needed_is_padding(scenarios):
    wide = stack(scenarios, [(0,)] * 8, capacity=(512, 256), width=1)
    assert wide.walls.vertical.at.shape == (512, 8)
    assert wide.walls.horizontal.at.shape == (256, 8)
    assert (wide.walls.horizontal.low <= wide.walls.horizontal.high).sum() == sum(len(s.horizontal) for s in scenarios)
