"""Tasks are parted by their walls where there are enough of them, and that changes nothing but the time."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from slcs2_jax.config import Compute, Radio, Rules, Settings, Swarm, World
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar import load_grammar, random_rule_sets
from slcs2_jax.running import batches as module
from slcs2_jax.running.deployable import of_grammar
from slcs2_jax.running.task import Measurement, Site
from slcs2_jax.world.arena import wall_capacity
from slcs2_jax.world.scenario import make_scenario

SETTINGS = Settings(
    world=dataclasses.replace(World.preset("urban"), distance=190.0, time_limit=60),
    swarm=Swarm(agents=3, packets=2),
    rules=Rules(rules=8),
    compute=Compute(devices=1, chunk=20),
)


def tasks(count: int) -> list[Measurement]:
    grammar = load_grammar("main")
    scenarios = [make_scenario(SETTINGS, seed) for seed in range(count)]
    rules = random_rule_sets(grammar, agents=3, rules=8, rng=np.random.default_rng(0))
    return [Measurement(Site.of(scenario, SETTINGS), of_grammar(grammar, rules), 2) for scenario in scenarios]


@pytest.fixture
def built(monkeypatch):
    """Batches whose rollouts are only described: the wall rows that they were asked for."""
    monkeypatch.setattr(
        module,
        "Rollout",
        lambda parameters, shape, like, **values: SimpleNamespace(
            walls=shape.walls,
            slots=values["slots"],
            slot_steps=0,
            compile_seconds=0.0,
            note=None,
            native=values["engine"] != "off",
            parameters=parameters,
        ),
    )
    return lambda some, settings=SETTINGS: module.make_batches(settings, some)


def test_few_tasks_share_one_rollout(built):
    [batch] = built(tasks(2 * module.LEAST_TASKS - 1))
    assert len(batch.tasks) == 2 * module.LEAST_TASKS - 1


def test_many_tasks_are_parted_into_those_with_few_and_with_many_walls(built):
    everybody = tasks(3 * module.LEAST_TASKS + 5)
    batches = built(everybody)
    assert 2 <= len(batches) <= 3
    assert sorted(id(task) for batch in batches for task in batch.tasks) == sorted(id(task) for task in everybody)
    assert all(len(batch.tasks) >= module.LEAST_TASKS for batch in batches)
    rows = [sum(batch.rollout.walls) for batch in batches]
    assert rows == sorted(rows)
    assert rows[0] < rows[-1]
    for batch in batches:
        assert batch.rollout.walls == wall_capacity([task.site.scenario for task in batch.tasks])


def test_worlds_without_walls_are_not_parted(built):
    open_world = dataclasses.replace(SETTINGS, world=World.preset("open"))
    everybody = tasks(3 * module.LEAST_TASKS)
    for task in everybody:
        task.site = dataclasses.replace(task.site, scenarios=(make_scenario(open_world, 0),))
    assert len(built(everybody)) == 1


@pytest.mark.parametrize("native", ["on", "off"])
def test_tasks_that_differ_in_physical_values_are_parted_where_xla_computes(built, native):
    compute = dataclasses.replace(SETTINGS.compute, native=native)
    points = [
        dataclasses.replace(SETTINGS, world=World.preset("open"), compute=compute, radio=Radio(noise_dbm=noise))
        for noise in (-90.0, -94.0, -90.0, -97.0)
    ]
    everybody = tasks(len(points))
    for task, settings in zip(everybody, points, strict=True):
        task.site = Site.of(make_scenario(settings, 0), settings)
    batches = built(everybody, points[0])
    parted = [[everybody.index(task) for task in batch.tasks] for batch in batches]
    assert parted == ([[0, 1, 2, 3]] if native == "on" else [[0, 2], [1], [3]])
    for batch in batches:
        own = Parameters.of(batch.tasks[0].site.settings)
        assert batch.rollout.parameters.physics.radio.noise == own.physics.radio.noise


@pytest.mark.parametrize("native", ["on", "off"])
def test_a_kept_rollout_serves_other_values_where_the_native_chunk_computes(built, native):
    settings = dataclasses.replace(SETTINGS, compute=dataclasses.replace(SETTINGS.compute, native=native))
    rollouts = module.Rollouts(settings)
    found = []
    for noise in (-90.0, -94.0, -90.0):
        [task] = tasks(1)
        point = dataclasses.replace(settings, radio=Radio(noise_dbm=noise))
        task.site = Site.of(task.site.scenario, point)
        [batch] = module.make_batches(point, [task], rollouts=rollouts)
        found.append(id(batch.rollout))
    assert found[0] == found[2]
    assert (found[0] == found[1]) == (native == "on")
