"""Run folders with known figures, made by the project's own writer, so that no test here computes an evolution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from slcs2_jax.config import Settings, World
from slcs2_jax.results import InstanceSummary, RunFolder, RunSummary
from slcs2_jax.results.arm import cell_named
from slcs2_jax.study.experiment import run_folder, settings_with

ARMS: dict[str, dict[str, Any]] = {
    "slcs2": {},
    "ailta": {"acceptance": "ailta"},
    "no_exchange": {"exchange": False},
    "channel": {"grammar": "channel"},
    "power": {"grammar": "power"},
    "both": {"grammar": "both"},
    "designed": {},
}


class Maker:
    """Writes runs below a folder: `make("ailta", "open_short", 3, [0.1, 0.2], fresh=0.15)`."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def settings(self, arm: str, cell: str, seed: int, generations: int, **own: Any) -> Settings:
        world = World.preset(*cell_named(cell))
        base = settings_with({"generations": generations, "seed": seed, "instances": 1, **own}, ARMS[arm])
        settings = replace(base, world=world)
        policy = arm if arm == "designed" else None
        return replace(settings, run_dir=str(run_folder(self.root, settings, policy)))

    def evolved(
        self,
        arm: str,
        cell: str,
        seed: int,
        best: Sequence[float],
        *,
        fresh: float | None = None,
        failed: float | None = None,
        planned: int | None = None,
        deployments: Sequence[int] = (),
        **own: Any,
    ) -> Path:
        """A run with these best figures so far by generation, of so many deployments, or two, of 50 time-steps each;
        it has ended if `fresh` is given."""
        settings = self.settings(arm, cell, seed, planned or len(best), **own)
        folder = RunFolder.create(settings, device="1 x cpu", kind="evolve")
        folder.append(
            {"instance": 0, "seed": seed, "generation": at, "fitness": value, "best": value, "steps": 50.0}
            | {"deployments": deployments[at] if deployments else 2}
            for at, value in enumerate(best)
        )
        if fresh is not None:
            one = InstanceSummary(
                seed=seed,
                generations=len(best),
                best_fitness=best[-1],
                fresh_mean=fresh,
                fresh_sd=0.1,
                evaluations=10,
                env_steps=1000,
                fresh_failed=failed,
            )
            asked = settings.search.generations
            summary = RunSummary(run_dir="", generations=asked, instances=(one,), env_steps_per_second=500.0)
            folder.write_timing(summary.timing())
            folder.write_summary(summary.to_json())
        return folder.path

    def designed(self, cell: str, seed: int, fitness: Sequence[float], **own: Any) -> Path:
        """The designed behaviour's deployments in one instance."""
        settings = self.settings("designed", cell, seed, 1, **own)
        folder = RunFolder.create(settings, device="1 x cpu", record={"policy": "designed"})
        folder.write_summary({"fitness": list(fitness)})
        return folder.path


@pytest.fixture
def make(tmp_path: Path) -> Maker:
    return Maker(tmp_path / "runs")
