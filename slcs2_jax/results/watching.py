"""How far runs are that another process computes: read from their folders again and again, without touching them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.door import present, reading, telling_damage
from slcs2_jax.results.files import storing
from slcs2_jax.results.lock import is_held
from slcs2_jax.results.reading import read_summary
from slcs2_jax.results.rows import LONGEST_ROW, bounded_lines, parse_row
from slcs2_jax.results.run_config import CONFIG, read_config
from slcs2_jax.results.run_folder import GENERATIONS, SUMMARY, most_rows
from slcs2_jax.results.sweep import runs_below

RESCAN = 15.0  # s after which new runs are looked for


@dataclass
class WatchedRun:
    """A run, and what its folder said last.

    generations, best: of each instance that has finished one, how many and the greatest fitness. evaluations,
    env_steps: of all rows. finished: has it ended? working: is a process computing it?
    """

    settings: Settings
    folder: Path
    generations: dict[int, int] = field(default_factory=dict)
    best: dict[int, float] = field(default_factory=dict)
    evaluations: int = 0
    env_steps: float = 0.0
    finished: bool = False
    working: bool = False
    _inode: int = 0
    _read_to: int = 0  # bytes

    @property
    def begun(self) -> bool:
        """Has it a folder yet?"""
        return present(self.folder / CONFIG)

    @property
    def done(self) -> int:
        """Generations of all instances."""
        return sum(self.generations.values())

    @property
    def planned(self) -> int:
        """Generations of all instances that there will be."""
        return self.settings.search.generations * self.settings.instances

    def look(self) -> None:
        """Read what came since the last look. Raises InputError naming a damaged file."""
        if not self.begun:
            return
        self._read_rows()
        if not self.finished and present(self.folder / SUMMARY):
            self.finished = read_summary(self.folder, read_config(self.folder)) is not None
        self.working = not self.finished and is_held(self.folder)

    def _read_rows(self) -> None:
        file = self.folder / GENERATIONS
        if not present(file):
            return
        most = most_rows(self.settings)
        try:
            with storing(file, "read"), reading(file, most * LONGEST_ROW) as rows:
                state = os.fstat(rows.fileno())
                if state.st_ino != self._inode or state.st_size < self._read_to:  # written anew, perhaps cut
                    self._inode, self._read_to = state.st_ino, 0
                    self.generations, self.best, self.evaluations, self.env_steps = {}, {}, 0, 0.0
                rows.seek(self._read_to)
                for line in bounded_lines(rows, most):
                    if not line.endswith(b"\n"):
                        break
                    self._read_to += len(line)
                    with telling_damage():
                        self._count(parse_row(line))
        except InputError as error:
            raise InputError(f"{file}: {error}; slcs2 resume {self.folder} says what can be done") from None

    def _count(self, row: dict[str, object]) -> None:
        instance, generation = int(row["instance"]), int(row["generation"])  # type: ignore[call-overload]
        self.generations[instance] = max(self.generations.get(instance, 0), generation + 1)
        self.best[instance] = max(self.best.get(instance, -1.0), float(row["best"]))  # type: ignore[arg-type]
        deployments = int(row["deployments"])  # type: ignore[call-overload]
        self.evaluations += deployments
        self.env_steps += deployments * float(row["steps"])  # type: ignore[arg-type]


@dataclass(frozen=True, kw_only=True)
class Pace:
    """Per second, of all runs together."""

    generations: float
    evaluations: float
    env_steps: float


class Watcher:
    """All runs in a folder and below it. Call `look` again and again; the rest says what was seen."""

    def __init__(self, folder: str | Path, clock: Callable[[], float] = time.monotonic) -> None:
        """Look for the first time. Raises InputError if there are no runs, or naming a damaged file."""
        self.folder = Path(folder)
        self.runs: list[WatchedRun] = []
        self._clock = clock
        self._scanned = -RESCAN
        self._first: tuple[float, int, int, float] | None = None  # after the first rows that came while looking
        self._last: tuple[float, int, int, float] | None = None
        self.look()

    def look(self) -> None:
        """Read what came since the last look. Raises InputError."""
        now = self._clock()
        if now - self._scanned >= RESCAN:
            self._scan()
            self._scanned = now
        for run in self.runs:
            run.look()
        seen = (now, self.done, sum(run.evaluations for run in self.runs), sum(run.env_steps for run in self.runs))
        if self._last is None or seen[1] < self._last[1]:  # for the first time, or rows were cut
            self._first, self._last = None, seen
        elif seen[1] > self._last[1]:
            self._first = self._first or seen
            self._last = seen

    def _scan(self) -> None:
        found, _ = runs_below(self.folder)
        if not found:
            raise InputError(
                f"folder={self.folder}: holds evaluations alone; accepted is a folder with runs of evolution"
            )
        known = {run.folder: run for run in self.runs}
        self.runs = []
        for settings in found:
            folder = Path(str(settings.run_dir))
            run = known.get(folder)
            if run is None or run.settings.search.generations != settings.search.generations:
                run = WatchedRun(settings, folder)
            self.runs.append(run)

    @property
    def done(self) -> int:
        """Generations of all instances of all runs."""
        return sum(run.done for run in self.runs)

    @property
    def planned(self) -> int:
        """Generations that there will be."""
        return sum(run.planned for run in self.runs)

    @property
    def finished(self) -> bool:
        """Have all runs ended?"""
        return all(run.finished for run in self.runs)

    @property
    def working(self) -> bool:
        """Is any of them being computed?"""
        return any(run.working for run in self.runs)

    @property
    def pace(self) -> Pace | None:
        """Measured between the first and the last rows that came while looking on; None before there are two."""
        if self._first is None or self._last is None or self._last[0] <= self._first[0]:
            return None
        seconds, *rates = (last - first for last, first in zip(self._last, self._first, strict=True))
        generations, evaluations, env_steps = (rate / seconds for rate in rates)
        return Pace(generations=generations, evaluations=evaluations, env_steps=env_steps)

    def groups(self) -> dict[str, list[WatchedRun]]:
        """The runs by the folder that holds those of one world, relative to the one that is watched."""
        found: dict[str, list[WatchedRun]] = {}
        for run in self.runs:
            place = run.folder.relative_to(self.folder)
            of_seeds = place.name.startswith("seed_")
            found.setdefault(str(place.parent if of_seeds else place), []).append(run)
        return found


def state_of(runs: Iterable[WatchedRun]) -> str:
    """running, finished, interrupted or waiting, of runs together."""
    runs = list(runs)
    if any(run.working for run in runs):
        return "running"
    if all(run.finished for run in runs):
        return "finished"
    return "interrupted" if any(run.begun and not run.finished for run in runs) else "waiting"
