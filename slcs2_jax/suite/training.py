"""Training: on train seeds, chosen on validation seeds, each training a run of its own that resumes.

Training r of a search for a world evolves in the world of train seed r, as the paper's searches do, or by turns in as
many as its entry says; that of a network draws its episodes from all train seeds. Its candidates, the best and the
fittest that a search held on to at its end, or the networks kept on the way, are then deployed in the validation
worlds; the fittest there is the artefact. Nothing of the test worlds is looked at.

ROOT/runs/ENTRY/WORLD/training_R is the run's folder, ROOT/artefacts/ENTRY/WORLD/training_R.npz the artefact, and beside
it training_R.json says what was spent and how the candidates fared.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import Compute, InputError, Search, Settings
from slcs2_jax.config.door import check_below, present
from slcs2_jax.config.errors import refuse
from slcs2_jax.config.field import check, described
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.policy.trained_network import NAME
from slcs2_jax.results import Report, SavedSolution, read_run
from slcs2_jax.results.documents import read_document, write_document
from slcs2_jax.results.files import storing
from slcs2_jax.results.policy_file import save_policy
from slcs2_jax.running import driver
from slcs2_jax.running.evaluator import Evaluator
from slcs2_jax.suite import networks
from slcs2_jax.suite.entries import Entry
from slcs2_jax.suite.measured import make_folders
from slcs2_jax.suite.worlds import SuiteWorld

CANDIDATES = 8  # of a training, that are deployed in the validation worlds
KIND, VERSION = "suite training", 1
_STEPS = {field.name: field for field in described(Search)}  # of generations, that a search makes at once


@dataclass(frozen=True, kw_only=True)
class Training:
    """One training that is to be made, or was.

    number: from 0; also that of its train seed. settings: of its run, with its folder. budget: of a search in episodes,
    of a network in env-steps. changes: of a network, the settings of its algorithm.
    """

    entry: Entry
    world: SuiteWorld
    number: int
    root: Path
    settings: Settings
    budget: int
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Of its artefact and of what is said about it."""
        return self.root / "artefacts" / self.entry.name / self.world.name

    @property
    def artefact(self) -> Path:
        """The file of what was chosen."""
        return self.folder / f"training_{self.number}.npz"

    @property
    def record(self) -> Path:
        """The file that says what was spent."""
        return self.folder / f"training_{self.number}.json"


def plan(
    entry: Entry,
    worlds: Sequence[SuiteWorld],
    root: Path,
    *,
    compute: Compute,
    trainings: int | None = None,
    episodes: int | None = None,
) -> list[Training]:
    """All trainings of an entry for these worlds.

    trainings: how many for each world; by default as the suite says. episodes: in place of the budget, for a trial; of
    a network, env-steps of so many whole episodes.

    Raises InputError for an entry that is not trained, or a setting that does not fit.
    """
    if not entry.trained:
        raise InputError(f"entry={entry.name}: is not trained; accepted is one that is: slcs2 suite list says which")
    found = []
    for world in worlds:
        for number in range(world.trainings if trainings is None else trainings):
            seed = world.seeds_of("train")[number]
            folder = root / "runs" / entry.name / world.name / f"training_{number}"
            if entry.algorithm:
                whole = max(1, int(entry.budget * world.env_steps))
                budget = whole if episodes is None else episodes * world.time_limit
                said, settings = networks.changes(entry, budget, CANDIDATES), world.settings(seed)
            else:
                budget = world.episodes if episodes is None else episodes
                own = {**(entry.settings or {}), **_budget(entry, budget), **_worlds(entry, world, number)}
                said, settings = {}, world.settings(seed, own)
            settings = dataclasses.replace(settings, run_dir=str(folder), compute=compute)
            found.append(Training(
                entry=entry, world=world, number=number, root=root, settings=settings, budget=budget, changes=said
            ))  # fmt: skip
    return found


def _budget(entry: Entry, episodes: int) -> dict[str, Any]:
    """So many deployments; a generation takes one at least, so that there can be no more generations.

    Raises InputError for a length of steps that is none.
    """
    settings = entry.settings or {}
    field = _STEPS["search.final_every" if settings.get("search.name") == "informed" else "search.batch"]
    step = check(field, settings[field.name]) if field.name in settings else 1
    generations = max(step, -(-episodes // step) * step)
    return {"generations": generations, "search.episodes": episodes, "search.fresh_deployments": 1}


def _worlds(entry: Entry, world: SuiteWorld, number: int) -> dict[str, Any]:
    """The train worlds of one training of a search that evolves in several: others than those of the one before.

    One kind of them, so that a race can end after the first. Raises InputError in a town from files.
    """
    if entry.train_worlds == 1:
        return {}
    if world.files:
        raise refuse("train_worlds", entry.train_worlds, f"1 in world {world.name}, whose towns come from files")
    seeds = world.seeds_of("train")
    count = min(entry.train_worlds, len(seeds))
    first = number * count % (len(seeds) - count + 1)
    return {"worlds": [f"{world.stated['world.environment']}/{seeds[first]}..{seeds[first + count - 1]}"]}


def train(trainings: Sequence[Training], report: Report) -> list[Path]:
    """Make all that are missing, searches together where they can share a batch, then choose; the artefacts made.

    Of networks the report is told of the env-steps of all of these trainings, one after another.

    Raises InputError if a world's checksum differs, or a folder holds something else; StorageError; Stopped, everything
    saved, so that the same call goes on.
    """
    for world in {one.world.name: one.world for one in trainings}.values():
        world.check()
    going = [one for one in trainings if not made(one)]
    if not going:
        return []
    for one in going:
        make_folders(one.root, Path(str(one.settings.run_dir)).parent)
        check_below(one.root, Path(str(one.settings.run_dir)))
    runtime.configure(going[0].settings.compute)
    searches = [one.settings for one in going if not one.entry.algorithm]
    if searches:
        driver.evolve(searches, report=report)
    evaluators: dict[tuple[str, str], Evaluator] = {}  # kept, so that a world's program is compiled once
    before = 0
    for one in going:
        if one.entry.algorithm:
            networks.train(one.entry, one.world, one.settings, one.budget, one.changes, _Following(report, before))
            before += one.budget
        report.note(f"{one.entry.name}, {one.world.name}, training {one.number}: choosing by the validation worlds")
        settings = dataclasses.replace(one.settings, run_dir=None)
        place = (one.entry.name, one.world.name)
        _choose(one, evaluators.setdefault(place, Evaluator(settings)))
    return [one.artefact for one in going]


@dataclass(frozen=True)
class _Following:
    """A report of a training that follows others, whose env-steps were `before` in all."""

    report: Report
    before: int

    def generation(self, *, done: Sequence[int], **figures: Any) -> None:
        self.report.generation(done=[self.before + sum(done)], **figures)

    def note(self, text: str) -> None:
        self.report.note(text)


def made(training: Training) -> bool:
    """Is its artefact there? Raises InputError if it is that of another configuration, or behind a link."""
    check_below(training.root, training.folder)
    if not (present(training.artefact) and present(training.record)):
        return False
    said = read_record(training.record)
    expected = (training.entry.digest, training.world.sha256, training.budget)
    if (said["digest"], said["sha256"], said["budget"]) != expected:
        raise InputError(
            f"{training.artefact}: was trained by another configuration, for other worlds or with another "
            "budget; accepted is another run_dir"
        )
    return True


def read_record(path: Path) -> dict[str, Any]:
    """What was spent on an artefact. Raises InputError naming the file if it is damaged."""
    try:
        with storing(path, "read"):
            said = read_document(path, KIND, VERSION)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    numbers = ("budget", "episodes", "env_steps", "validation_episodes", "validation_env_steps")
    texts = all(isinstance(said.get(name), str) for name in ("digest", "sha256"))
    if not texts or not all(type(said.get(name)) is int and said[name] >= 0 for name in numbers):
        raise InputError(f"{path}: is not what training leaves")
    return said


def candidates(settings: Settings) -> list[SavedSolution]:
    """The best solution of a run that has ended, and the fittest others that it held on to at its end."""
    run = read_run(str(settings.run_dir))
    best = run.best(0)
    others = [one for one in run.members(0) if one.generation != best.generation]
    others.sort(key=lambda one: (-one.fitness, one.generation))
    return [best, *others[: CANDIDATES - 1]]


def _choose(training: Training, evaluator: Evaluator) -> None:
    """Deploy the candidates once in each validation world, and save the fittest and what was spent."""
    world = training.world
    held, said = _held(training)
    found = evaluator(held, [world.scenario(seed) for seed in world.seeds_of("validation")])
    fitness = found.fitness[:, :, 0]  # [candidates, worlds]
    chosen = int(np.argmax(fitness.mean(axis=1)))  # of equals the fitter in training, or the network trained longer
    make_folders(training.root, training.folder)
    best = held[chosen]
    if isinstance(best, SavedSolution):
        bare(best).save(training.artefact, inside=training.root)
    else:
        about = {"algorithm": training.entry.algorithm, "env_steps": said["kept_after"][chosen]}
        save_policy(training.artefact, NAME, best.given, about, inside=training.root)
    content = {
        "digest": training.entry.digest,
        "sha256": world.sha256,
        "budget": training.budget,
        "validation_episodes": int(fitness.size),
        "validation_env_steps": int(found.steps.sum()),
        "validation": [[round(float(value), 6) for value in row] for row in fitness],
        "chosen": chosen,
        **said,
    }
    write_document(training.record, KIND, VERSION, content, inside=training.root)


def _held(training: Training) -> tuple[Sequence[SavedSolution | BoundPolicy], dict[str, Any]]:
    """The candidates of a training that has ended, the fittest or longest trained first, and what the record says."""
    folder = Path(str(training.settings.run_dir))
    if training.entry.algorithm:
        kept = networks.candidates(folder)
        episodes, env_steps = networks.spent(folder)
        return list(kept.values()), {"episodes": episodes, "env_steps": env_steps, "kept_after": list(kept)}
    [instance] = (read_run(str(folder)).summary or {})["instances"]
    return candidates(training.settings), {"episodes": instance["evaluations"], "env_steps": instance["env_steps"]}


def bare(solution: SavedSolution) -> SavedSolution:
    """The same rules without what they had learnt and where they came from: what is deployed needs neither."""
    shape = solution.rules.action.shape
    return dataclasses.replace(
        solution,
        quality=np.zeros(shape, np.float32),
        strength=np.zeros(shape, np.float32),
        error=np.zeros(shape, np.float32),
        usage=np.zeros(shape, np.int32),
        origin_kind=None,
        origin_generation=None,
        origin_agent=None,
    )
