"""Runs that are interrupted, and what they leave behind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import slcs2_jax as slcs2


def results(folder) -> dict[str, bytes]:
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.name: path.read_bytes() for path in files if path.name not in ("config.yaml", "timing.json")}


class Crash(BaseException):
    """Nobody expects it."""


class Crasher:
    """Crashes at a call."""

    def __init__(self, call: int) -> None:
        self.left = call

    def generation(self, **values) -> None:
        self.left -= 1
        if self.left == 0:
            raise Crash

    def note(self, text: str) -> None:
        pass


def crash_and_go_on(settings: slcs2.Settings, calls: Sequence[int], **more: Any) -> None:
    """Evolve to the end, after interruptions at these calls of the report, at least two of which must come."""
    crashes = 0
    for call in (*calls, 1000):
        try:
            slcs2.evolve(settings, report=Crasher(call), **more)
        except Crash:
            crashes += 1
    assert crashes >= 2


def assert_same_however_interrupted(settings: Any, folder: Any, batch: int) -> None:
    """A run, one that is interrupted anywhere, and one that was shorter at first: the same bytes.

    `settings` makes those of a run from its folder and fields of the search.
    """
    slcs2.evolve(settings(folder / "once", batch=batch))
    crash_and_go_on(settings(folder / "again", batch=batch), (3, 4, 5, 6, 7, 8))
    assert results(folder / "again") == results(folder / "once")
    slcs2.evolve(settings(folder / "further", generations=5, batch=batch))
    slcs2.evolve(settings(folder / "further", batch=batch))
    assert results(folder / "further") == results(folder / "once")
