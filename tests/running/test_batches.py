"""Tasks are parted by their walls where there are enough of them, and that changes nothing but the time."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from slcs2_jax.config import Compute, Rules, Settings, Swarm, World
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
            walls=shape.walls, slots=values["slots"], slot_steps=0, compile_seconds=0.0, note=None
        ),
    )
    return lambda some: module.make_batches(SETTINGS, some)


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
