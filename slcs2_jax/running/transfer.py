"""Winners deployed in worlds that they have not seen: each in each, kept on disk as it goes.

A job is a policy in a world, deployed so many times. Its name follows from all that decides what it comes to, so a
folder that holds some jobs already is gone on with, whatever else was asked of it before.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from slcs2_jax.config import Compute, InputError, Knowledge, Search, Settings, settings_to_dict
from slcs2_jax.config.door import present, telling_damage
from slcs2_jax.config.worlds import Kind
from slcs2_jax.results import Report
from slcs2_jax.results.rows import append_rows, drop_torn_end, read_rows
from slcs2_jax.running.deployable import Deployable
from slcs2_jax.running.evaluator import Evaluator

DEPLOYED = "deployments.jsonl"
_AGAIN = "delete it, and everything is deployed again"
_TOGETHER = 8  # policies that are deployed at once, and then kept


@dataclass(frozen=True, eq=False, kw_only=True)
class Traveller:
    """Something to be deployed elsewhere.

    Attributes:
        policy: what it is.
        content: all that tells it from others, for the names of its jobs.
        settings: it is deployed with, but for the world.
    """

    policy: Deployable
    content: str
    settings: Settings


@dataclass(frozen=True, eq=False)
class _Job:
    traveller: Traveller
    kind: Kind
    seed: int
    name: str


def deployed_in(settings: Settings, compute: Compute) -> Settings:
    """The settings of a run as they are for its winner elsewhere: without search and knowledge."""
    return replace(
        settings, search=Search(), knowledge=Knowledge(), compute=compute, seed=0, instances=1, run_dir=None, worlds=()
    )


def travel(
    travellers: Sequence[Traveller], kinds: Sequence[Kind], *, deployments: int, folder: Path, report: Report | None
) -> list[list[list[float]]]:
    """Deploy everything everywhere, but for what the folder holds already.

    Returns:
        For each traveller, for each kind, the mean fitness in each of its worlds.

    Raises:
        InputError: a damaged file, or a policy that does not fit its settings; StorageError.
    """
    file = folder / DEPLOYED
    known = known_deployments(file)
    jobs = [
        _Job(one, kind, seed, _name(one, kind, seed, deployments))
        for one in travellers
        for kind in kinds
        for seed in kind.seeds
    ]
    drop_torn_end(file)
    evaluators: dict[Settings, Evaluator] = {}
    for settings, some, seeds in _lots([job for job in jobs if job.name not in known]):
        evaluator = evaluators.setdefault(settings, Evaluator(settings))
        policies = [one.policy for one in dict.fromkeys(job.traveller for job in some)]
        found = evaluator(policies, seeds, deployments=deployments, report=report)
        rows = []
        for job, fitness in zip(some, found.fitness.reshape(-1, deployments).tolist(), strict=True):
            known[job.name] = fitness
            rows.append({"job": job.name, "fitness": fitness})
        append_rows(file, rows)
    if any(len(known[job.name]) != deployments for job in jobs):
        raise InputError(f"{file}: figures of more or fewer deployments than their names say; {_AGAIN}")
    means = iter([sum(known[job.name]) / deployments for job in jobs])
    return [[[next(means) for _ in kind.seeds] for kind in kinds] for _ in travellers]


def known_deployments(file: Path) -> dict[str, list[float]]:
    """What the folder holds, by the names of jobs. Raises InputError naming a damaged file."""
    if not present(file):
        return {}
    try:
        with telling_damage():
            return {str(row["job"]): [float(one) for one in row["fitness"]] for row in read_rows(file)}
    except InputError as error:
        raise InputError(f"{file}: {error}; {_AGAIN}") from None


def _name(traveller: Traveller, kind: Kind, seed: int, deployments: int) -> str:
    settings = settings_to_dict(replace(kind.settings(traveller.settings), compute=Compute()))
    said = json.dumps([traveller.content, settings, seed, deployments], sort_keys=True)
    return hashlib.sha256(said.encode("utf-8", "surrogatepass")).hexdigest()[:32]


def _lots(jobs: Sequence[_Job]) -> Iterator[tuple[Settings, list[_Job], list[int]]]:
    """Jobs that are computed at once, with their seeds: some policies in the same worlds, policy by policy."""
    rows: dict[tuple[Settings, Traveller], list[_Job]] = {}
    for job in jobs:
        rows.setdefault((job.kind.settings(job.traveller.settings), job.traveller), []).append(job)
    alike: dict[tuple[Settings, tuple[int, ...]], list[list[_Job]]] = {}
    for (settings, _), own in rows.items():
        alike.setdefault((settings, tuple(job.seed for job in own)), []).append(own)
    for (settings, seeds), several in alike.items():
        for start in range(0, len(several), _TOGETHER):
            yield settings, [job for own in several[start : start + _TOGETHER] for job in own], list(seeds)
