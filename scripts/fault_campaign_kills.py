"""Kill runs at random moments and let them go on: what differs in the end from runs that nothing happened to?"""

from __future__ import annotations

import functools
import json
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import fault_campaign_suite as suite

from slcs2_jax.config import InputError
from slcs2_jax.learning.training_folder import FORMAT as TRAINING_FORMAT
from slcs2_jax.results.archive import read_archive
from slcs2_jax.results.run_folder import CHECKPOINT, CHECKPOINT_FORMAT, CONFIG, GENERATIONS

SMALL = (
    "world.distance=190",
    "world.time_limit=200",
    "swarm.agents=3",
    "swarm.packets=4",
    "rules.rules=10",
    "search.fresh_deployments=4",
    "compute.devices=1",
    "compute.chunk=50",
)
EVOLVING = {
    "evolve": ("evolve", *SMALL, "checkpoint.generations=2", "instances=3"),
    "sweep": (
        "evolve",
        "-m",
        *SMALL,
        "checkpoint.generations=2",
        "acceptance=domination,ailta",
        "seed=0,100",
        "instances=2",
    ),
    "parts": (
        "evolve",
        *SMALL,
        "environment=urban_jammed",
        "jammers.count=2",
        "jammers.motion=pursue",
        "jammers.emission=sweeping",
        "world.distance=400",
        "radio.fading=nakagami",
        "swarm.failure_rate=0.01",
        "swarm.recovery_steps=20",
        "compute.native=on",
        "checkpoint.generations=2",
        "instances=2",
    ),
    "informed": (
        "evolve",
        *SMALL,
        "search=informed",
        "rules.rules=40",
        "compute.native=on",
        "checkpoint.generations=2",
        "instances=2",
    ),
    "experiment": ("experiment", "contributions", *SMALL, "environment=open", "range=short", "instances=2"),
}
# what is typed for a folder after `suite`, and the training that must be there before
SUITES = {
    "networks": (("train", f"{suite.STRATEGY},{suite.IPPO}", "episodes=200"), False),
    "suite train": (("train", f"{suite.SEARCH},{suite.RACED}", "episodes=60"), False),
    "suite evaluate": (("evaluate", ",".join(suite.ENTRIES[:3]), "deployments=30"), True),
}
SIGNALS = {signal.SIGKILL: 0.7, signal.SIGTERM: 0.15, signal.SIGINT: 0.15}
NO_RESULT = ("config.yaml", "timing.json", "lock")  # when, where and how fast a run was made
UNFINISHED = ".tmp"  # hidden files that a kill left beside those that were being written


@dataclass
class Figures:
    """What the campaign found; all but the first two must be 0 or empty."""

    kills: dict[str, int] = field(default_factory=dict)
    restarts: int = 0
    differing: list[str] = field(default_factory=list)
    lost_generations: int = 0  # saved before a kill and not there after it, or not saved by a heeded signal
    tracebacks: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Killed:
    """A command that is killed and called again.

    Attributes:
        typed: for a folder.
        before: makes the folder, if something must be there before.
        program: of Python, that is given what is typed.
    """

    typed: Callable[[Path], list[str]]
    before: Callable[[Path], None] | None = None
    program: tuple[str, ...] = ("-m", "slcs2_jax")


def cases(folder: Path, generations: int) -> dict[str, Killed]:
    """All of them by name; `folder` is for what they need."""
    found = {}
    for name, command in EVOLVING.items():
        found[name] = Killed(functools.partial(_in, [*command, f"generations={generations}"]))
    suite.write_entries(folder / "suite")
    program = (suite.__file__,)
    for name, ((action, entries, *options), trained) in SUITES.items():
        files = ",".join(str(folder / "suite" / entry) for entry in entries.split(","))
        typed = ["suite", action, files, *options, f"world={suite.WORLD}", "compute.devices=1"]
        before = functools.partial(_trained, folder / "suite") if trained else None
        found[name] = Killed(functools.partial(_in, typed), before, program)
    elsewhere = [f"worlds=[open/9000000..{9000000 + 40}]", "deployments=5", "compute.devices=1"]
    found["transfer"] = Killed(lambda place: ["transfer", str(place), *elsewhere], functools.partial(_run, folder))
    return found


def _in(typed: list[str], place: Path) -> list[str]:
    return [*typed, f"run_dir={place}"]


def _trained(root: Path, place: Path) -> None:
    """What slcs2 suite train leaves, made once."""
    if not (root / "artefacts").exists():
        files = ",".join(str(root / entry) for entry in (suite.SEARCH, suite.STRATEGY))
        typed = ["suite", "train", files, f"world={suite.WORLD}", f"run_dir={root}", "compute.devices=1"]
        subprocess.run([sys.executable, suite.__file__, *typed], check=True, capture_output=True)
    shutil.copytree(root / "artefacts", place / "artefacts")


def _run(folder: Path, place: Path) -> None:
    """A finished run, made once."""
    run = folder / "run"
    if not run.exists():
        typed = _in([*EVOLVING["evolve"], "generations=4"], run)
        subprocess.run([sys.executable, "-m", "slcs2_jax", *typed], check=True, capture_output=True)
    shutil.copytree(run, place)


def kills(count: int, folder: Path, *, seed: int = 0, generations: int = 40, only: str = "") -> Figures:
    """So many kills, spread over the commands in whose names `only` is found; `folder` is for the runs."""
    chance, figures = random.Random(seed), Figures()
    chosen = {name: case for name, case in cases(folder, generations).items() if re.search(only, name)}
    shares = [count // len(chosen) + (place < count % len(chosen)) for place in range(len(chosen))]
    for share, (name, case) in zip(shares, chosen.items(), strict=True):
        _Case(folder / name, case, chance, figures, name).run(share)
    return figures


def results(folder: Path) -> dict[str, bytes]:
    """The bytes of everything that a command leaves but when, where and how fast it was made."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.is_file() and path.name not in NO_RESULT and path.suffix != UNFINISHED and name.parts[0] != "report":
            found[str(name)] = path.read_bytes()
    return found


class _Case:
    def __init__(self, folder: Path, case: Killed, chance: random.Random, figures: Figures, name: str) -> None:
        self.folder, self.case, self.chance, self.figures, self.name = folder, case, chance, figures, name

    def run(self, count: int) -> None:
        """Kill `count` times, in as many trials as that takes."""
        if not count:
            return
        whole, again = self._begin("whole"), self._begin("again")
        self._finish(self.case.typed(whole))
        start = time.monotonic()
        self._finish(self.case.typed(again))  # with compiled programs at hand: so long a trial takes
        self.seconds = time.monotonic() - start
        expected = results(whole)
        self._compare(expected, again)
        left, trial = count, 0
        while left:
            place = self._begin(f"trial_{trial}")
            left -= self._trial(place, min(left, self.chance.randint(1, 4)))
            self._finish(self.case.typed(place))
            self._compare(expected, place)
            trial += 1

    def _trial(self, place: Path, most: int) -> int:
        """Start and kill up to `most` times; returns how often it was killed."""
        made, saved, command = 0, {}, self.case.typed(place)
        while made < most:
            number = self.chance.choices(list(SIGNALS), list(SIGNALS.values()))[0]
            process = self._start(command)
            self.figures.restarts += made > 0
            try:
                process.wait(self.chance.uniform(0.15, 1.0) * self.seconds)
            except subprocess.TimeoutExpired:
                process.send_signal(number)
            _, errors = process.communicate()
            if process.returncode == 0:
                return made
            made += 1
            self._note(number, process.returncode, errors)
            before, saved = saved, _saved(place)
            self.figures.lost_generations += sum(max(0, done - saved.get(run, 0)) for run, done in before.items())
            if process.returncode == 128 + number:  # heeded: nothing may be unsaved
                self.figures.lost_generations += sum(
                    max(0, _rows(place / run, instance) - done) for (run, instance), done in saved.items()
                )
            command = self.chance.choice([self.case.typed(place), self._resume(place)])
        return made

    def _note(self, number: signal.Signals, code: int, errors: str) -> None:
        key = f"{self.name} {number.name}"
        self.figures.kills[key] = self.figures.kills.get(key, 0) + 1
        heard = code in (-number, 128 + number)
        # before the program itself runs, Python answers SIGINT with a traceback of its own
        if not heard or ("Traceback" in errors and "KeyboardInterrupt" not in errors):
            self.figures.tracebacks.append(f"{key}: exit code {code}: {errors[-800:]}")

    def _begin(self, name: str) -> Path:
        place = self.folder / name
        if self.case.before:
            self.case.before(place)
        return place

    def _resume(self, place: Path) -> list[str]:
        begun = self.name in EVOLVING and place.exists() and any(place.rglob(CONFIG))
        return ["resume", str(place)] if begun else self.case.typed(place)

    def _start(self, command: list[str]) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, *self.case.program, *command],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def _finish(self, command: list[str]) -> None:
        process = self._start(command)
        _, errors = process.communicate()
        if process.returncode:
            self.figures.tracebacks.append(f"{' '.join(command)}: exit code {process.returncode}: {errors[-800:]}")

    def _compare(self, expected: dict[str, bytes], place: Path) -> None:
        found = results(place)
        names = expected.keys() | found.keys()
        self.figures.differing += [f"{place}/{name}" for name in names if expected.get(name) != found.get(name)]


def _saved(place: Path) -> dict[tuple[str, int], int]:
    """Generations saved, by run folder and instance; of a network env-steps. Raises InputError if a checkpoint is
    damaged."""
    found = {}
    for file in place.rglob(CHECKPOINT):
        name = str(file.parent.relative_to(place))
        try:
            _, about = read_archive(file, CHECKPOINT_FORMAT)
        except InputError:
            _, about = read_archive(file, TRAINING_FORMAT)
            found[name, 0] = about["counters"]["env_steps"]
            continue
        for instance, meta in enumerate(about["instances"]):
            found[name, instance] = meta["search"]["generation"]
    return found


def _rows(folder: Path, instance: int) -> int:
    lines = (folder / GENERATIONS).read_text().splitlines() if (folder / GENERATIONS).exists() else []
    return sum(json.loads(line)["instance"] == instance for line in lines)
