"""Runs to look at: a finished one, and the same as it was before it ended."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from slcs2_jax.config import Checkpoint, Compute, Rules, Search, Settings, Swarm, World
from slcs2_jax.evolution import driver
from slcs2_jax.results.run_folder import SOLUTIONS, SUMMARY


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
