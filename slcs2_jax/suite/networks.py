"""Training of a network for a kind of world: in all of its train seeds, gone on with where it was stopped.

ROOT/runs/ENTRY/WORLD/training_R is its folder (docs/howto/train_network.md). Of those kept on the way, at even
distances, and the last, the one that the validation worlds choose is the artefact.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config import InputError, Settings
from slcs2_jax.learning import algorithms
from slcs2_jax.learning.training_folder import POLICY
from slcs2_jax.policy.bound import BoundPolicy, load_bound
from slcs2_jax.policy.trained_network import TrainedNetwork
from slcs2_jax.results import Report
from slcs2_jax.results.policy_file import load_policy
from slcs2_jax.suite.entries import Entry
from slcs2_jax.suite.worlds import SuiteWorld


def changes(entry: Entry, budget: int, kept: int) -> dict[str, Any]:
    """The settings of a training of so many env-steps that keeps so many networks, by their names.

    IPPO's learning rate falls to 0 in that budget unless the entry says otherwise. Raises InputError naming the entry
    for a setting that is none or does not fit.
    """
    found = {f"{entry.algorithm}.snapshot": -(-budget // kept), **(entry.settings or {})}
    if entry.algorithm == "ippo":
        found.setdefault("ippo.anneal", budget)
    try:
        algorithms.settings_of(entry.algorithm, found)
    except InputError as error:
        raise InputError(f"entry={entry.name}: {error}") from None
    return found


def train(
    entry: Entry, world: SuiteWorld, settings: Settings, budget: int, said: Mapping[str, Any], report: Report
) -> None:
    """Train, or go on.

    Args:
        entry, world: what, and where.
        settings: of the world of the training's own seed, with its folder.
        budget: env-steps.
        said: as `changes` gives them.
        report: who is told of progress.

    Raises:
        InputError: naming entry, world and folder, for numbers that are not finite any more or a folder that holds
            something else.
        StorageError: the disk refuses. Stopped: by a signal, all saved.
    """
    try:
        algorithms.train(
            entry.algorithm,
            said,
            places(world, settings),
            seed=settings.seed,
            budget_env_steps=budget,
            folder=settings.run_dir,
            report=report,
        )
    except InputError as error:
        raise InputError(f"entry={entry.name}, world={world.name}, seed={settings.seed}: {error}") from None


def places(world: SuiteWorld, settings: Settings) -> Sequence[tuple[Settings, Sequence[int]]]:
    """The train seeds with their settings: one group, or one for each file that walls come from."""
    groups: dict[str | None, tuple[Settings, list[int]]] = {}
    for seed in world.seeds_of("train"):
        made = dataclasses.replace(world.settings(seed), compute=settings.compute)
        groups.setdefault(made.world.file, (made, []))[1].append(seed)
    return list(groups.values())


def candidates(folder: Path) -> dict[int, BoundPolicy]:
    """The networks of a training that has ended by the env-steps after which each was kept, the last first.

    Raises InputError naming a damaged file.
    """
    return dict(reversed(dict(algorithms.kept(folder)).items()))


def spent(folder: Path) -> tuple[int, int]:
    """Episodes begun and env-steps done in a training that has ended. Raises InputError naming a damaged file."""
    about = load_policy(folder / POLICY).about
    episodes, env_steps = (algorithms.count_in(about, name, folder / POLICY) for name in ("episodes", "env_steps"))
    return episodes, env_steps


def network_in(file: Path) -> BoundPolicy:
    """The network of an artefact. Raises InputError naming the file if it is damaged, another policy, or not finite."""
    found, _ = load_bound(file)
    if not isinstance(found.policy, TrainedNetwork):
        raise InputError(f"policy={file}: is no trained network; accepted is what slcs2 suite train leaves")
    return found
