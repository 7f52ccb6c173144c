"""Scenarios follow from (settings, seed) alone, and keep every promise of model section 2."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapely
from scipy import stats

from slcs2_jax.config import InputError, Radio, Settings, Swarm, World
from slcs2_jax.world.scenario import make_scenario

TYPES = ("open", "jammed", "urban", "urban_jammed")
RANGES = ("short", "long")
CELLS = [(kind, reach) for kind in TYPES for reach in RANGES]
SEEDS = range(60)
RECORDED = {  # urban_jammed, short, seed 0: numbers of walls, first vertical wall, jammer, last agent's start
    "walls": (18, 23),
    "wall": [34.508522, -44.004173, -23.180754],
    "jammer": [395.21466, -29.797384],
    "start": [15.77757, -32.308464],
}


def settings(kind, reach="short", **sections):
    return Settings(world=World.preset(kind, reach), **sections)


@pytest.fixture(scope="module")
def scenarios():
    return {
        cell: [make_scenario(settings(*cell, swarm=Swarm(sink_error=5.0)), seed) for seed in SEEDS] for cell in CELLS
    }


def fields(scenario):
    return {f.name: getattr(scenario, f.name) for f in dataclasses.fields(scenario)}


def same(one, other):
    of = [{**fields(s), "jammers": len(s.jammers)} for s in (one, other)]
    alike = all(np.array_equal(a, b) for a, b in zip(*(each.values() for each in of), strict=True))
    return alike and all(map(same_jammer, one.jammers, other.jammers))


def same_jammer(one, other):
    return all(np.array_equal(a, b) for a, b in zip(fields(one).values(), fields(other).values(), strict=True))


def solid(s):
    half = s.wall_thickness / 2
    return [shapely.box(x - half, a, x + half, b) for x, a, b in s.vertical.astype(float)] + [
        shapely.box(a, y - half, b, y + half) for y, a, b in s.horizontal.astype(float)
    ]


@pytest.mark.parametrize("cell", CELLS)
def test_the_same_seed_gives_the_same_scenario_and_others_differ(cell, scenarios):
    again = make_scenario(settings(*cell, swarm=Swarm(sink_error=5.0)), 3)
    assert same(scenarios[cell][3], again)
    assert not np.array_equal(scenarios[cell][3].start, scenarios[cell][4].start)


def test_nothing_but_the_world_the_radio_and_the_swarm_enters():
    a = make_scenario(settings("urban_jammed", seed=1, instances=2), 7)
    b = make_scenario(settings("urban_jammed", seed=99, run_dir="elsewhere"), 7)
    assert same(a, b)


def test_a_recorded_scenario_stays_what_it_was():
    """So that runs made with an earlier version can be repeated."""
    s = make_scenario(settings("urban_jammed"), 0)
    assert (len(s.vertical), len(s.horizontal)) == RECORDED["walls"]
    np.testing.assert_allclose(s.vertical[0], RECORDED["wall"], rtol=1e-6)
    np.testing.assert_allclose(s.jammer, RECORDED["jammer"], rtol=1e-6)
    np.testing.assert_allclose(s.start[-1], RECORDED["start"], rtol=1e-6)


def test_scenarios_are_in_single_precision():
    s = make_scenario(settings("urban_jammed"), 0)
    for name in ("vertical", "horizontal", "start", "sink", "sink_estimate", "jammer"):
        assert getattr(s, name).dtype == np.float32


@pytest.mark.parametrize("reach", RANGES)
def test_distance_and_time_limit_of_the_paper(reach, scenarios):
    for kind in TYPES:
        s = scenarios[kind, reach][0]
        distance, limit = {"short": (600, 20_000), "long": (1000, 40_000)}[reach]
        np.testing.assert_array_equal(s.sink, [distance, 0])
        assert s.time_limit == limit
        assert s.environment == kind


@pytest.mark.parametrize("cell", CELLS)
def test_only_what_the_type_says_is_there(cell, scenarios):
    for s in scenarios[cell]:
        assert (s.jammer is not None) == ("jammed" in cell[0])
        assert "urban" in cell[0] or s.walls == 0
    if "urban" in cell[0]:
        assert np.mean([s.walls > 0 for s in scenarios[cell]]) > 0.9


@pytest.mark.parametrize("reach", RANGES)
def test_types_of_the_same_seed_share_buildings_jammer_and_sink(reach, scenarios):
    for seed in SEEDS:
        of = {kind: scenarios[kind, reach][seed] for kind in TYPES}
        np.testing.assert_array_equal(of["urban"].vertical, of["urban_jammed"].vertical)
        np.testing.assert_array_equal(of["urban"].horizontal, of["urban_jammed"].horizontal)
        np.testing.assert_array_equal(of["urban"].start, of["urban_jammed"].start)
        np.testing.assert_array_equal(of["jammed"].jammer, of["urban_jammed"].jammer)
        np.testing.assert_array_equal(of["open"].start, of["jammed"].start)
        np.testing.assert_array_equal(of["open"].sink_estimate, of["urban"].sink_estimate)


@pytest.mark.parametrize("cell", [c for c in CELLS if "urban" in c[0]])
def test_walls_lie_where_buildings_may_and_cover_nothing_that_matters(cell, scenarios):
    for s in scenarios[cell]:
        distance = s.sink[0]
        v, h = s.vertical, s.horizontal
        assert ((v[:, 2] - v[:, 1] >= 10 - 1e-3) & (v[:, 2] - v[:, 1] <= 30 + 1e-3)).all()
        assert ((h[:, 2] - h[:, 1] >= 10 - 1e-3) & (h[:, 2] - h[:, 1] <= 30 + 1e-3)).all()
        assert ((v[:, 0] >= -15) & (v[:, 0] <= distance + 15)).all()
        assert ((h[:, 0] >= -115) & (h[:, 0] <= 115)).all()
        assert ((v[:, 1] >= -115) & (v[:, 2] <= 115)).all()
        assert ((h[:, 1] >= -15) & (h[:, 2] <= distance + 15)).all()
        points = shapely.points(np.concatenate([[[0, 0]], s.sink[None], s.start]).astype(float))
        if s.walls:
            assert not shapely.covers(np.array(solid(s))[:, None], points).any()


def test_the_number_of_buildings_and_walls(scenarios):
    """Uniform on 1..60 buildings, six walls each with probability a half: 91.5 walls on average."""
    counts = [s.walls for s in scenarios["urban", "short"]]
    assert np.mean(counts) == pytest.approx(3 * 30.5, abs=4 * 3 * 17.3 / np.sqrt(len(counts)))
    assert max(counts) <= 6 * 60


def test_a_lone_building_has_at_most_three_walls_across_and_three_along():
    world = dataclasses.replace(World.preset("urban"), building_spacing=600.0, wall_probability=1.0)
    for seed in range(20):
        s = make_scenario(Settings(world=world), seed)
        v, h = np.sort(s.vertical[:, 0]), np.sort(s.horizontal[:, 0])
        if len(v) < 3 or len(h) < 3:
            continue  # one that would cover the source or the sink is left out
        np.testing.assert_allclose(v[1], (v[0] + v[2]) / 2, atol=1e-3)
        np.testing.assert_allclose(h[1], (h[0] + h[2]) / 2, atol=1e-3)
        np.testing.assert_allclose(s.vertical[:, 1], h[0], atol=1e-3)
        np.testing.assert_allclose(s.vertical[:, 2], h[2], atol=1e-3)
        np.testing.assert_allclose(s.horizontal[:, 1], v[0], atol=1e-3)
        np.testing.assert_allclose(s.horizontal[:, 2], v[2], atol=1e-3)


@pytest.mark.parametrize("reach", RANGES)
def test_the_jammer_affects_neither_source_nor_sink(reach, scenarios):
    net = Radio().network_range
    along = np.array([s.jammer[0] for s in scenarios["jammed", reach]])
    across = np.array([s.jammer[1] for s in scenarios["jammed", reach]])
    distance = scenarios["jammed", reach][0].sink[0]
    assert ((along > net) & (along < distance - net)).all()
    assert (np.abs(across) <= 100).all()
    assert stats.kstest((along - net) / (distance - 2 * net), "uniform").pvalue > 1e-3
    assert stats.kstest((across + 100) / 200, "uniform").pvalue > 1e-3


@pytest.mark.parametrize("cell", CELLS)
def test_starts_are_in_the_disc_and_a_clearance_apart(cell, scenarios):
    for s in scenarios[cell]:
        assert s.start.shape == (12, 2)
        assert (np.hypot(*s.start.T) <= 50 + 1e-3).all()
        apart = np.hypot(*(s.start[:, None] - s.start).T)
        assert apart[~np.eye(12, dtype=bool)].min() >= 2 - 1e-4


def test_starts_are_uniform_in_the_disc(scenarios):
    radius = np.concatenate([np.hypot(*s.start.T) for s in scenarios["open", "short"]])
    assert stats.kstest((radius / 50) ** 2, "uniform").pvalue > 1e-3


def test_a_crowded_start_keeps_the_clearance():
    s = make_scenario(Settings(world=World(start_radius=20.0), swarm=Swarm(agents=64, clearance=2.5)), 0)
    apart = np.hypot(*(s.start[:, None] - s.start).T)
    assert apart[~np.eye(64, dtype=bool)].min() >= 2.5 - 1e-4


def test_the_sinks_estimate_is_off_by_the_error_asked_for(scenarios):
    exact = make_scenario(settings("open"), 0)
    np.testing.assert_array_equal(exact.sink, exact.sink_estimate)
    off = np.concatenate([s.sink_estimate - s.sink for s in scenarios["open", "short"]])
    assert np.std(off) == pytest.approx(5, rel=0.25)
    assert abs(np.mean(off)) < 2


def one_line(caught):
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_no_place_for_the_jammer_is_refused():
    with pytest.raises(InputError) as caught:
        settings("jammed", radio=Radio(power_dbm=40.0))
    message = one_line(caught)
    assert "world.distance=600" in message
    assert "jammer" in message


def test_no_place_for_the_agents_is_refused():
    with pytest.raises(InputError) as caught:
        Settings(world=World(start_radius=3.0), swarm=Swarm(agents=20))
    assert "swarm.agents=20" in one_line(caught)


def test_walls_that_leave_no_place_for_the_agents_are_refused():
    """A start disc so small, and walls so thick, that the walls cover nearly all of it."""
    world = dataclasses.replace(
        World.preset("urban"), start_radius=9.0, wall_thickness=10.0, strip_half_width=20.0, building_spacing=2.0,
        distance=600.0, wall_probability=1.0,
    )  # fmt: skip
    crowded = Settings(world=world, swarm=Swarm(agents=15))

    def make_many():
        return [make_scenario(crowded, seed) for seed in range(40)]

    with pytest.raises(InputError) as caught:
        make_many()
    message = one_line(caught)
    assert "swarm.agents=15" in message
    assert "start_radius" in message
