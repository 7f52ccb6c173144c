"""A suite of two small worlds, made of the frozen ones, so that tests take seconds."""

from __future__ import annotations

import dataclasses

import pytest

from slcs2_jax.suite import worlds
from slcs2_jax.suite.worlds import Suite, SuiteWorld

SMALL = {"world.distance": 200.0, "world.time_limit": 600, "swarm.packets": 6, "swarm.agents": 4}


def small(world: SuiteWorld, **stated) -> SuiteWorld:
    """The world with few seeds and short episodes, its checksum its own."""
    made = dataclasses.replace(
        world,
        stated={**world.stated, **SMALL, **stated},
        seeds={
            split: (first, count) for (split, (first, _)), count in zip(world.seeds.items(), (2, 2, 3), strict=True)
        },
        files={},
        trainings=2,
        env_steps=6 * 600,
    )
    return dataclasses.replace(made, sha256=made.found)


@pytest.fixture(scope="session")
def tiny() -> Suite:
    full = worlds.load_suite()
    chosen = {name: small(full.worlds[name]) for name in ("open_short", "few")}
    return dataclasses.replace(full, worlds=chosen, deployments=2)


@pytest.fixture
def in_use(tiny, monkeypatch):
    """The small suite in the place of the frozen one, and no shipped results."""
    monkeypatch.setattr(worlds, "load_suite", lambda: tiny)
    return tiny


@pytest.fixture(autouse=True)
def nothing_shipped(monkeypatch, tmp_path):
    from slcs2_jax.suite import measured

    monkeypatch.setattr(measured, "shipped_root", lambda: tmp_path / "nothing shipped")
