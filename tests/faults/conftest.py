"""A run small enough to be made hundreds of times, and what must be equal where runs are."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from slcs2_jax.config import Checkpoint, Compute, Rules, Search, Settings, Swarm, World
from slcs2_jax.running import driver

GENERATIONS = 3


def tiny(run_dir: Path | None, *, generations: int = GENERATIONS, **values) -> Settings:
    """Two instances of three agents, saved after every generation."""
    settings = Settings(
        world=World(distance=120.0, time_limit=60),
        swarm=Swarm(agents=3, packets=3),
        rules=Rules(rules=6),
        search=Search(generations=generations, fresh_deployments=2),
        compute=Compute(devices=1, chunk=20),
        checkpoint=Checkpoint(generations=1, seconds=None),
        instances=2,
        run_dir=None if run_dir is None else str(run_dir),
    )
    return dataclasses.replace(settings, **values)


def results(folder: Path) -> dict[str, bytes]:
    """The bytes of everything in a run folder but when, where and how fast it was made."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in files
        if path.name not in ("config.yaml", "timing.json")
    }


class Tiny:
    """What the tests of faults share."""

    settings = staticmethod(tiny)
    results = staticmethod(results)


@pytest.fixture(scope="session")
def tiny_run() -> type[Tiny]:
    return Tiny


@pytest.fixture(scope="session")
def finished(tmp_path_factory) -> Path:
    """A run that nothing happened to. Not to be changed."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    driver.evolve([tiny(folder)])
    return folder
