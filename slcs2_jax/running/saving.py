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
    """Saves the checkpoints of runs that have folders, the one that waited longest first.

    By the clock a run is saved when `checkpoint.seconds` have passed since it was saved last and there is something
    new. After each such save comes a pause so long that all of them take at most `SHARE` of the time: with many runs
    their saves are spread. A run whose unsaved generations reach `checkpoint.generations` is saved in any case.
    """

    def __init__(self, members: Sequence[Run], clock: Callable[[], float] = time.perf_counter) -> None:
        """`members`: the runs that advance together; their present state counts as saved."""
        self._clock, self._start = clock, clock()
        self._saved = {id(one): _Saved(one.progress, self._start) for one in members if one.folder is not None}
        self._members = [one for one in members if one.folder is not None]
        self._pause_until = self._start

    def after_chunk(self) -> None:
        """Save what is due. Raises StorageError."""
        now = self._clock()
        going = [one for one in self._members if one.summary is None]
        for one in going:
            if self._by_generations(one):
                self._save(one)
        due = [one for one in going if self._by_time(one, now)]
        if due and now >= self._pause_until:
            first = min(due, key=lambda one: self._saved[id(one)].time)
            seconds = self._save(first)
            self._pause_until = self._clock() + seconds * (1 - SHARE) / SHARE

    def save_all(self) -> None:
        """Save every run that has something new. Raises StorageError."""
        for one in self._members:
            if one.summary is None and one.progress != self._saved[id(one)].progress:
                self._save(one)

    def _by_generations(self, one: Run) -> bool:
        limit = one.settings.checkpoint.generations
        if limit is None:
            return False
        pairs = zip(one.progress, self._saved[id(one)].progress, strict=True)
        return max(now - before for (now, _), (before, _) in pairs) >= limit

    def _by_time(self, one: Run, now: float) -> bool:
        limit, saved = one.settings.checkpoint.seconds, self._saved[id(one)]
        return limit is not None and now - saved.time >= limit and one.progress != saved.progress

    def _save(self, one: Run) -> float:
        start = self._clock()
        one.save(start - self._start)
        end = self._clock()
        self._saved[id(one)] = _Saved(one.progress, end)
        return end - start
