"""A behaviour in many worlds at once comes to what it does in each alone."""

from dataclasses import replace

import pytest

from slcs2_jax.config import Settings, Swarm, World
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.running import driver
from slcs2_jax.running.deployed import deploy_list


def small(environment: str, seed: int, instances: int) -> Settings:
    world = replace(World.preset(environment), time_limit=600)
    return Settings(world=world, swarm=Swarm(agents=6, packets=4), seed=seed, instances=instances)


def test_many_worlds_are_each_one_alone():
    behaviour = load_decision_list("designed")
    runs = [small("open", 3, 2), small("urban", 0, 1), small("jammed", 7, 1)]
    found = deploy_list(runs, behaviour, deployments=2)
    assert [[len(instance) for instance in own] for own in found] == [[2, 2], [2], [2]]
    for settings, own in zip(runs, found, strict=True):
        alone = driver.evaluate_list(settings, behaviour, deployments=2)
        means = [sum(one.fitness for one in instance) / 2 for instance in own]
        assert means == pytest.approx([scenario.fitness for scenario in alone.scenarios])
