"""Factors: which settings differ between runs, and from where single changes are told."""

from dataclasses import replace

from slcs2_jax.config import Radio, Search, Settings, Swarm, World
from slcs2_jax.results.arm import Cell
from slcs2_jax.study.factor import factors, point_of, point_text, shared_changes, values_of

OPEN, LONG = Cell("open", "short"), Cell("open", "long")


def test_nothing_differs_but_what_tells_arms_worlds_and_lengths_apart():
    runs = [
        Settings(),
        Settings(seed=3, instances=2, world=World.preset("urban_jammed", "long")),
        Settings(search=Search(acceptance="ailta", exchange=False, generations=9)),
    ]
    assert factors(runs) == ()


def test_values_in_order_and_the_default_for_a_base():
    runs = [Settings(swarm=Swarm(speed=speed), radio=Radio(noise_dbm=-90.0)) for speed in (4.0, 1.0, 2.0)]
    [speed] = factors(runs)
    assert (speed.name, speed.values, speed.base[OPEN]) == ("swarm.speed", (1.0, 2.0, 4.0), 2.0)
    assert (speed.default, speed.unit, speed.numeric) == (2.0, "m/step", True)
    assert [point_text(point_of(one, [speed])) for one in runs] == ["swarm.speed=4.0", "swarm.speed=1.0", ""]
    assert values_of(runs[0], [speed]) == {"swarm.speed": 4.0}
    assert shared_changes(runs) == [("radio.noise_dbm", -90.0, -94.0)]


def test_without_a_default_the_base_is_a_combination_that_occurs():
    runs = [Settings(swarm=Swarm(speed=s), radio=Radio(noise_dbm=n)) for s, n in ((3.0, -90.0), (4.0, -91.0))]
    noise, speed = factors(runs)
    assert (noise.base[OPEN], speed.base[OPEN]) == (-91.0, 4.0)


def test_what_the_world_sets_is_a_factor_only_within_a_world():
    near, far = Settings(world=World.preset("open", "short")), Settings(world=World.preset("open", "long"))
    assert factors([near, far]) == ()
    nearer = replace(near, world=replace(near.world, distance=300.0))
    assert shared_changes([nearer]) == [("world.distance", 300.0, near.world.distance)]
    assert shared_changes([near]) == shared_changes([far]) == shared_changes([near, nearer]) == []
    [distance] = factors([near, far, nearer])
    assert (distance.base[OPEN], distance.base[LONG]) == (near.world.distance, far.world.distance)
    assert [point_of(one, [distance]) for one in (near, far, nearer)] == [(), (), (("world.distance", 300.0),)]


def test_deployments_change_what_a_fresh_mean_is():
    [found] = factors([Settings(), Settings(search=Search(fresh_deployments=5))])
    assert found.name == "search.fresh_deployments"
