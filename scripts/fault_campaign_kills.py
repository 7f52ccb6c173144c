"""Kill runs at random moments and let them go on: what differs in the end from runs that nothing happened to?"""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from slcs2_jax.commands import COMMANDS
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
CASES = {
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


def kills(count: int, folder: Path, *, seed: int = 0, generations: int = 40) -> Figures:
    """So many kills, spread over the commands; `folder` is for the runs."""
    chance, figures = random.Random(seed), Figures()
    cases = {name: command for name, command in CASES.items() if command[0] in COMMANDS}
    shares = [count // len(cases) + (place < count % len(cases)) for place in range(len(cases))]
    for share, (name, command) in zip(shares, cases.items(), strict=True):
        case = _Case(folder / name, [*command, f"generations={generations}"], chance, figures, name)
        case.run(share)
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
    def __init__(self, folder: Path, command: list[str], chance: random.Random, figures: Figures, name: str) -> None:
        self.folder, self.command, self.chance, self.figures, self.name = folder, command, chance, figures, name

    def run(self, count: int) -> None:
        """Kill `count` times, in as many trials as that takes."""
        if not count:
            return
        whole = self.folder / "whole"
        self._finish(self._repeat(whole))
        start = time.monotonic()
        self._finish(self._repeat(self.folder / "again"))  # with compiled programs at hand: so long a trial takes
        self.seconds = time.monotonic() - start
        expected = results(whole)
        self._compare(expected, self.folder / "again")
        left, trial = count, 0
        while left:
            place = self.folder / f"trial_{trial}"
            left -= self._trial(place, min(left, self.chance.randint(1, 4)))
            self._finish(self._repeat(place))
            self._compare(expected, place)
            trial += 1

    def _trial(self, place: Path, most: int) -> int:
        """Start and kill up to `most` times; returns how often it was killed."""
        made, saved, command = 0, {}, self._repeat(place)
        while made < most:
            number = self.chance.choices(list(SIGNALS), list(SIGNALS.values()))[0]
            process = _start(command)
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
                    _rows(place / run, instance) - done for (run, instance), done in saved.items()
                )
            command = self.chance.choice([self._repeat(place), self._resume(place)])
        return made

    def _note(self, number: signal.Signals, code: int, errors: str) -> None:
        key = f"{self.name} {number.name}"
        self.figures.kills[key] = self.figures.kills.get(key, 0) + 1
        heard = code in (-number, 128 + number)
        # before the program itself runs, Python answers SIGINT with a traceback of its own
        if not heard or ("Traceback" in errors and "KeyboardInterrupt" not in errors):
            self.figures.tracebacks.append(f"{key}: exit code {code}: {errors[-800:]}")

    def _repeat(self, place: Path) -> list[str]:
        return [*self.command, f"run_dir={place}"]

    def _resume(self, place: Path) -> list[str]:
        begun = place.exists() and any(place.rglob(CONFIG))
        return ["resume", str(place)] if begun else self._repeat(place)

    def _finish(self, command: list[str]) -> None:
        process = _start(command)
        _, errors = process.communicate()
        if process.returncode:
            self.figures.tracebacks.append(f"{' '.join(command)}: exit code {process.returncode}: {errors[-800:]}")

    def _compare(self, expected: dict[str, bytes], place: Path) -> None:
        found = results(place)
        names = expected.keys() | found.keys()
        self.figures.differing += [f"{place}/{name}" for name in names if expected.get(name) != found.get(name)]


def _start(command: list[str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "slcs2_jax", *command],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def _saved(place: Path) -> dict[tuple[str, int], int]:
    """Generations saved, by run folder and instance. Raises InputError if a checkpoint is damaged."""
    found = {}
    for file in place.rglob(CHECKPOINT):
        _, about = read_archive(file, CHECKPOINT_FORMAT)
        for instance, meta in enumerate(about["instances"]):
            found[str(file.parent.relative_to(place)), instance] = meta["search"]["generation"]
    return found


def _rows(folder: Path, instance: int) -> int:
    lines = (folder / GENERATIONS).read_text().splitlines() if (folder / GENERATIONS).exists() else []
    return sum(json.loads(line)["instance"] == instance for line in lines)
