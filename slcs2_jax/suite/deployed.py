"""An entry as something to deploy in a world: its rules, its trainings' artefacts, or what a user brings."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.door import read_file
from slcs2_jax.policy.bound import bind, load_bound
from slcs2_jax.results import SavedSolution, load_solution
from slcs2_jax.results.policy_file import FORMAT as POLICY_FORMAT
from slcs2_jax.running.deployable import Deployable
from slcs2_jax.suite.entries import Entry, artefact
from slcs2_jax.suite.networks import network_in
from slcs2_jax.suite.worlds import SuiteWorld

_POLICY = POLICY_FORMAT.rpartition(" ")[0]  # stands in the complaint about the format of what is no solution
_LARGEST = 2**30  # bytes of an artefact, which was read before


class Ready(NamedTuple):
    """Policies, one for each training, settings that they fit, and the SHA-256 of all of them."""

    policies: list[Deployable]
    settings: Settings
    digest: str


def ready(entry: Entry, world: SuiteWorld, seed: int, roots: Sequence[Path], trainings: Sequence[int]) -> Ready:
    """What is deployed in the world of a seed.

    Args:
        entry: what.
        world, seed: where.
        roots: folders with artefacts, the first first.
        trainings: numbers of those that are deployed, of an entry that is trained.

    Raises:
        InputError: an entry that has not been trained for this world, or a file that is damaged or of another version.
    """
    settings = world.settings(seed, None if entry.algorithm else entry.settings)
    if entry.trained:
        files = [_trained(entry, world, number, roots) for number in trainings]
        opened = network_in if entry.algorithm else policy_in
        policies = [opened(file) for file in files]
        digest = hashlib.sha256(b"".join(hashlib.sha256(read_file(file, _LARGEST)).digest() for file in files))
        return Ready(policies, settings, digest.hexdigest())
    if entry.path is not None:
        policy = policy_in(entry.path)
        if isinstance(policy, SavedSolution):  # how many rules, and how they learn, is its own
            own = {name: getattr(policy.settings, name) for name in ("rules", "learning")}
            settings = dataclasses.replace(settings, **own)
        return Ready([policy], settings, entry.digest)
    if entry.content:
        return Ready([entry.decision_list()], settings, entry.digest)
    return Ready([bind(entry.name, ())], settings, entry.digest)


def _trained(entry: Entry, world: SuiteWorld, number: int, roots: Sequence[Path]) -> Path:
    file = artefact(entry, world.name, number, roots)
    if file is None:
        raise InputError(
            f"entry={entry.name}: has no artefact of training {number} in world {world.name}; accepted is one that "
            f"slcs2 suite train {entry.name} world={world.name} has made"
        )
    return file


def policy_in(file: Path) -> Deployable:
    """The policy of a file of either format. Raises InputError naming it if it is damaged or of another version."""
    try:
        return load_solution(file)
    except InputError as error:
        if _POLICY not in str(error):
            raise
    return load_bound(file)[0]
