"""slcs2 watch: how far runs are that another process computes."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from datetime import datetime
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.looked_at import told_apart
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from rich.table import Table

    from slcs2_jax.results.watching import WatchedRun, Watcher

TAKES_SETTINGS = False
HELP = """\
slcs2 watch FOLDER [every=SECONDS] [once=on]: progress of the runs in a folder and below it, until all have ended

For each world: runs that have ended, generations of all instances, best fitness so far (mean and best of the
instances), and whether a process works on it. Then, of all together, evaluations and time-steps per second since the
command was started, and the time left at that rate. Reads the folders and changes nothing there; may be started and
left (Ctrl-C) at any time, on any machine that sees the folder.

  every=2           seconds from look to look
  once=off          on: look once and end
"""
_DEFAULTS: dict[str, Any] = {"every": 2, "once": False}
OPTIONS = tuple(_DEFAULTS)
_STATES = ("running", "interrupted", "waiting", "finished")  # in this order from above
_FRAME = 7  # lines of a terminal that are not rows of the table


def run(arguments: list[str]) -> int:
    """Watch the folder that the arguments name."""
    folders, options, others = told_apart(arguments, _DEFAULTS)
    if len(folders) != 1:
        raise InputError(f"watch: {len(folders)} folders; accepted is slcs2 watch FOLDER [every=SECONDS] [once=on]")
    if others:
        raise refuse("option", others[0].partition("=")[0], "one of " + ", ".join(_DEFAULTS))
    if not 1 <= options["every"] <= 3600:
        raise refuse("every", options["every"], "a whole number of seconds from 1 to 3600")
    from slcs2_jax.results.watching import Watcher

    watcher = Watcher(folders[0])
    if options["once"]:
        from rich.console import Console

        Console().print(_table(watcher, math.inf), _overall(watcher), sep="\n", highlight=False, markup=False)
        return 0
    try:
        (_live if sys.stdout.isatty() else _lines)(watcher, options["every"])
    except KeyboardInterrupt:  # to stop looking is no failure
        print()
    return 0


def _looks(watcher: Watcher, every: int) -> Iterator[None]:
    """After each look, the last when all runs have ended."""
    yield
    while not watcher.finished:
        time.sleep(every)
        watcher.look()
        yield


def _live(watcher: Watcher, every: int) -> None:
    from rich.console import Console, Group
    from rich.live import Live
    from rich.text import Text

    console = Console()
    with Live(console=console, auto_refresh=False) as live:
        for _ in _looks(watcher, every):
            table = _table(watcher, max(1, console.height - _FRAME))
            live.update(Group(table, Text(_overall(watcher))), refresh=True)


def _lines(watcher: Watcher, every: int) -> None:
    said = ""
    for _ in _looks(watcher, every):
        line = _overall(watcher)
        if line != said:
            print(f"{datetime.now():%H:%M:%S} {line}", flush=True)
            said = line


def _table(watcher: Watcher, most: float) -> Table:
    """A row for each world, those that are computed first, as many as fit."""
    from rich.table import Table
    from rich.text import Text

    from slcs2_jax.results.watching import state_of

    groups = sorted(watcher.groups().items(), key=lambda one: _STATES.index(state_of(one[1])))
    table = Table(box=None, padding=(0, 1, 0, 0))
    table.add_column("runs of", overflow="ellipsis")
    for name, width in (("ended", 5), ("generations", 11), ("", 4), ("mean", 6), ("best", 6)):
        table.add_column(name, justify="right", no_wrap=True, min_width=width)
    table.add_column("state", no_wrap=True, min_width=len("interrupted"))
    for place, (name, runs) in enumerate(groups):
        if place >= most:
            table.add_row(f"and {len(groups) - place} more")
            break
        table.add_row(Text(terminal(name)), *_row(runs), state_of(runs))  # a text: brackets are no markup
    return table


def _row(runs: list[WatchedRun]) -> tuple[str, ...]:
    done, planned = sum(run.done for run in runs), sum(run.planned for run in runs)
    best = [value for run in runs for value in run.best.values()]
    figures = (f"{sum(best) / len(best):.3f}", f"{max(best):.3f}") if best else ("-", "-")
    ended = sum(run.finished for run in runs)
    return f"{ended}/{len(runs)}", f"{done:,}/{planned:,}", f"{done / planned:.0%}", *figures


def _overall(watcher: Watcher) -> str:
    """All runs together in a line."""
    from slcs2_jax.results.progress import duration

    ended = sum(run.finished for run in watcher.runs)
    parts = [
        f"{ended} of {len(watcher.runs)} runs have ended",
        f"{watcher.done:,} of {watcher.planned:,} generations",
    ]
    pace = watcher.pace
    if watcher.finished:
        return ", ".join(parts)
    if not watcher.working:
        return ", ".join([*parts, "no process works on them"])
    if pace is None:
        return ", ".join([*parts, "measuring the pace"])
    left = duration((watcher.planned - watcher.done) / pace.generations)
    parts += [f"{pace.evaluations:.1f} evaluations/s", f"{pace.env_steps:,.0f} env-steps/s", f"{left} left"]
    return ", ".join(parts)
