"""Entries deployed in test or validation worlds: the same worlds and the same random numbers for all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import Compute
from slcs2_jax.results import Report
from slcs2_jax.running.evaluator import Evaluator
from slcs2_jax.suite import measured
from slcs2_jax.suite.deployed import ready
from slcs2_jax.suite.entries import Entry, artefact
from slcs2_jax.suite.measured import Measured
from slcs2_jax.suite.training import read_record
from slcs2_jax.suite.worlds import SuiteWorld, seeds_of


def evaluate(
    entry: Entry,
    world: SuiteWorld,
    root: Path,
    *,
    compute: Compute,
    deployments: int,
    split: str = "test",
    seeds: int | None = None,
    trainings: int | None = None,
    report: Report,
) -> Measured:
    """Deploy an entry in the worlds of a kind, unless the folder says what that came to.

    Args:
        entry, world: what, and where.
        root: folder of artefacts and results; what the suite comes with is looked at after it.
        compute: how the machine is used.
        deployments: in each world.
        split: test, to be looked at once, or validation, to tune by.
        seeds: so many worlds, the first ones; all by default.
        trainings: of an entry that is trained, the first so many; by default as the suite says.
        report: who is told of progress.

    Raises:
        InputError: another checksum, an entry that is not trained or does not fit, or gives what is no number.
        StorageError: the disk refuses.
    """
    chosen = seeds_of(world, split, seeds)
    roots = (root, measured.shipped_root())
    numbers = range(world.trainings if trainings is None else trainings)
    deployed = ready(entry, world, chosen[0], roots, numbers)
    known = measured.load(root, entry.name, world, split)
    if known is not None and known.digest == deployed.digest and _covers(known, chosen, deployments):
        return known
    world.check()
    settings = deployed.settings
    runtime.configure(compute)
    evaluator = Evaluator(dataclasses.replace(settings, compute=compute))
    scenarios = [world.scenario(seed) for seed in chosen]
    found = evaluator(deployed.policies, scenarios, deployments=deployments, report=report)
    episodes, env_steps = _spent(entry, world, len(deployed.policies), roots)
    result = Measured(
        version=world.version,
        world=world.name,
        sha256=world.sha256,
        entry=entry.name,
        title=entry.title,
        field=entry.field,
        digest=deployed.digest,
        split=split,
        seeds=np.array(chosen, np.int64),
        delivered=found.delivered.astype(np.int32),
        steps=found.steps.astype(np.int32),
        episodes=episodes,
        env_steps=env_steps,
    )
    result.save(root)
    return result


def _covers(known: Measured, seeds: Sequence[int], deployments: int) -> bool:
    """Are at least these deployments measured?"""
    return set(seeds) <= set(known.seeds.tolist()) and known.steps.shape[2] >= deployments


def _spent(entry: Entry, world: SuiteWorld, trainings: int, roots: Sequence[Path]) -> tuple[int, int]:
    """Episodes and time-steps that all trainings took, their validation included; 0 of what is not trained."""
    if not entry.trained:
        return 0, 0
    files = [artefact(entry, world.name, number, roots) for number in range(trainings)]
    said = [read_record(file.with_suffix(".json")) for file in files if file is not None]
    episodes = sum(one["episodes"] + one["validation_episodes"] for one in said)
    return episodes, sum(one["env_steps"] + one["validation_env_steps"] for one in said)
