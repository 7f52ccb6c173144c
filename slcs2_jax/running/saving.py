"""When runs are saved while they go on: often enough to lose little, seldom enough to cost nothing."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from slcs2_jax.running.run import Run

SHARE = 0.005  # of the time may go into saving by the clock


@dataclass(eq=False)
class _Saved:
    """What was last saved of a run, and when."""

    progress: list[tuple[int, int]]
    time: float


class Saver:
    """Saves the checkpoints of runs that have folders, that which waited longest first.

    By the clock a run is saved when `checkpoint.seconds` have passed since it was saved last and there is something
    new. After each such save comes a pause so long that all of them take at most `SHARE` of the time: with many runs
    their saves are spread. A run whose unsaved generations reach `checkpoint.generations` is saved in any case.
    """

    def __init__(self, runs: Sequence[Run], clock: Callable[[], float] = time.perf_counter) -> None:
        """`runs`: those that advance together; their present state counts as saved."""
        self._clock, self._start = clock, clock()
        self._saved = {id(run): _Saved(run.progress, self._start) for run in runs if run.folder is not None}
        self._runs = [run for run in runs if run.folder is not None]
        self._pause_until = self._start

    def after_chunk(self) -> None:
        """Save what is due. Raises StorageError."""
        now = self._clock()
        going = [run for run in self._runs if run.summary is None]
        for run in going:
            if self._by_generations(run):
                self._save(run)
        due = [run for run in going if self._by_time(run, now)]
        if due and now >= self._pause_until:
            first = min(due, key=lambda run: self._saved[id(run)].time)
            seconds = self._save(first)
            self._pause_until = self._clock() + seconds * (1 - SHARE) / SHARE

    def save_all(self) -> None:
        """Save every run that has something new. Raises StorageError."""
        for run in self._runs:
            if run.summary is None and run.progress != self._saved[id(run)].progress:
                self._save(run)

    def _by_generations(self, run: Run) -> bool:
        limit = run.settings.checkpoint.generations
        if limit is None:
            return False
        pairs = zip(run.progress, self._saved[id(run)].progress, strict=True)
        return max(now - before for (now, _), (before, _) in pairs) >= limit

    def _by_time(self, run: Run, now: float) -> bool:
        limit, saved = run.settings.checkpoint.seconds, self._saved[id(run)]
        return limit is not None and now - saved.time >= limit and run.progress != saved.progress

    def _save(self, run: Run) -> float:
        start = self._clock()
        run.save(start - self._start)
        end = self._clock()
        self._saved[id(run)] = _Saved(run.progress, end)
        return end - start
