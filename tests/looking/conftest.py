"""Runs to look at: a finished one, and the same as it was before it ended."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest

from slcs2_jax.config import Checkpoint, Compute, Jammers, Radio, Rules, Search, Settings, Swarm, World
from slcs2_jax.grammar import load_grammar, random_rule_sets
from slcs2_jax.looking.recorder import record
from slcs2_jax.looking.recording import Recording
from slcs2_jax.looking.solutions import replay
from slcs2_jax.policy.bound import bind_rules
from slcs2_jax.results import read_run
from slcs2_jax.results.run_folder import SOLUTIONS, SUMMARY
from slcs2_jax.running import driver
from slcs2_jax.search import fresh_deployment_key
from slcs2_jax.world.scenario import make_scenario


@pytest.fixture(scope="session")
def finished(tmp_path_factory) -> Path:
    """Two instances of three agents, four generations. Not to be changed."""
    folder = tmp_path_factory.mktemp("looking") / "run"
    settings = Settings(
        world=World(distance=190.0, time_limit=300),
        swarm=Swarm(agents=3, packets=4),
        rules=Rules(rules=12),
        search=Search(generations=4, fresh_deployments=2),
        compute=Compute(devices=1, chunk=50),
        checkpoint=Checkpoint(generations=1, seconds=None),
        instances=2,
        run_dir=str(folder),
    )
    driver.evolve([settings])
    return folder


@pytest.fixture
def under_way(finished, tmp_path) -> Path:
    """The run as it lay there before its solutions and its summary were written."""
    folder = tmp_path / "under_way"
    shutil.copytree(finished, folder)
    (folder / SUMMARY).unlink()
    shutil.rmtree(folder / SOLUTIONS)
    return folder


@pytest.fixture(scope="session")
def episode(finished) -> Recording:
    """A replay of the first instance's best solution."""
    return replay(read_run(finished).best(0))


@pytest.fixture(scope="session")
def jammed_episode() -> Recording:
    """Random rules among buildings, near a jammer."""
    agents = 4
    settings = Settings(
        world=dataclasses.replace(World.preset("urban_jammed"), distance=110.0, time_limit=400),
        radio=Radio(power_dbm=6.5),  # net is 54 m
        swarm=Swarm(agents=agents, packets=4),
        compute=Compute(devices=1),
    )
    grammar = load_grammar("main")
    rules = random_rule_sets(grammar, agents, 40, np.random.default_rng(4))
    key = fresh_deployment_key(7, 1)
    return record(settings, make_scenario(settings, 7), bind_rules(rules, grammar), key)


@pytest.fixture(scope="session")
def troubled_episode() -> Recording:
    """Random rules on three channels; three jammers that sweep and patrol; agents that fail and recover."""
    agents = 4
    settings = Settings(
        world=dataclasses.replace(World.preset("jammed"), distance=150.0, time_limit=120),
        radio=Radio(power_dbm=6.5, fading="rayleigh"),
        jammers=Jammers(count=3, emission="sweeping", motion="patrol", dwell=7, power_db=-3.0),
        swarm=Swarm(agents=agents, packets=4, failure_rate=0.02, recovery_steps=15.0),
        compute=Compute(devices=1),
    )
    grammar = load_grammar("both")
    rules = random_rule_sets(grammar, agents, 40, np.random.default_rng(4))
    key = fresh_deployment_key(7, 1)
    return record(settings, make_scenario(settings, 7), bind_rules(rules, grammar), key)
