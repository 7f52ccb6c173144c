"""What a person sees while runs go on: a live bar on a terminal, plain lines where there is none."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Protocol, TextIO, TypeVar

from slcs2_jax.config.escape import terminal

Item = TypeVar("Item")
_PATIENCE = 2.0  # s that work on the host may take without a word


class Report(Protocol):
    """What the driver calls while it works; `Progress` shows it, and anything with these two methods will do."""

    def generation(self, *, done: Sequence[int], best: Sequence[float], evaluations: int, env_steps: int) -> None:
        """After every generation of any instance, one entry per instance of all runs, in a fixed order.

        done: generations finished by each; best: best fitness of each so far (NaN before the first);
        evaluations, env_steps: episodes and their time-steps, in all, since the start.
        """
        ...

    def note(self, text: str) -> None:
        """Something worth a line: what is being compiled, what is measured afterwards."""
        ...


class Progress:
    """Shows a `Report` on stderr: use as a context manager.

    Args:
        total: generations of one instance.
        stream: where to (stderr); a bar if it is a terminal, else lines.
        label: what is counted.
        afterwards: what goes on when all of it is counted; "" if nothing does.
        clock: seconds; for tests.
    """

    def __init__(
        self,
        total: int,
        *,
        stream: TextIO | None = None,
        label: str = "generation",
        afterwards: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._total, self._label, self._afterwards, self._clock = total, label, afterwards, clock
        self._stream = sys.stderr if stream is None else stream
        self._start = clock()
        self._first: tuple[float, float] | None = None  # time and share done at the first call: leaves compiling out
        self._shown = 0
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Progress:
        if self._stream.isatty():
            self._bar = _bar(self._stream)
            self._task = self._bar.add_task(f"{self._label} 0/{self._total}", total=1.0, left="starting", more="")
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def note(self, text: str) -> None:
        """One line."""
        text = terminal(text)
        if self._bar is not None:
            self._bar.console.print(text, highlight=False, markup=False)
        else:
            print(text, file=self._stream, flush=True)

    def generation(self, *, done: Sequence[int], best: Sequence[float], evaluations: int, env_steps: int) -> None:
        """See `Report.generation`. A line is written when the slowest instance has finished another generation."""
        now = self._clock()
        share = sum(done) / (len(done) * self._total)
        if self._first is None:
            self._first = (now, share)
        seconds = max(now - self._start, 1e-9)
        finished = min(done)
        counted = f"{self._label} {finished}/{self._total}"
        left = self._afterwards if share >= 1 and self._afterwards else f"{self._left(now, share)} left"
        more = (
            f"best {_figures(best)}  {evaluations / seconds:.1f} evaluations/s  {env_steps / seconds:,.0f} env-steps/s"
        )
        if self._bar is not None:
            self._bar.update(self._task, completed=share, description=counted, left=left, more=more)
        elif finished > self._shown:
            self._shown = finished
            print(f"{counted}  {left}  {more}", file=self._stream, flush=True)

    def _left(self, now: float, share: float) -> str:
        assert self._first is not None
        then, share_then = self._first
        if share >= 1:
            return duration(0)
        if share <= share_then or now <= then:  # nothing but the first call to go by
            return duration((now - self._start) / share * (1 - share)) if share > 0 else "?"
        return duration((now - then) / (share - share_then) * (1 - share))


def _bar(stream: TextIO) -> Any:
    """A live line that keeps what matters most, the time left, where the terminal is narrow; its end is cut first."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar
    from rich.table import Column

    def text(field: str, **column: Any) -> TextColumn:
        return TextColumn(field, markup=False, table_column=Column(no_wrap=True, **column))

    columns = (
        text("{task.description}"),
        BarColumn(bar_width=12),
        TimeElapsedColumn(table_column=Column(no_wrap=True)),
        text("{task.fields[left]}"),
        text("{task.fields[more]}", overflow="ellipsis", ratio=1),
    )
    return Bar(*columns, console=Console(file=stream), transient=False, expand=True)


class Quiet:
    """A `Report` that shows nothing."""

    def generation(self, *, done: Sequence[int], best: Sequence[float], evaluations: int, env_steps: int) -> None:
        """Nothing."""

    def note(self, text: str) -> None:
        """Nothing."""


@contextmanager
def counting(label: str) -> Iterator[Callable[..., None]]:
    """Yields what to tell how far a short computation is (done, and of how many): a live line on a terminal alone."""
    if not sys.stderr.isatty():
        yield lambda done, total=None: None
        return
    from rich.console import Console

    with Console(stderr=True).status(label) as status:
        yield lambda done, total=None: status.update(f"{label} {done:,d}" + (f"/{total:,d}" if total else ""))


def counted(
    items: Sequence[Item],
    label: str,
    *,
    stream: TextIO | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Item]:
    """The items one by one. Once that takes over 2 s, stderr shows how many are done: on a terminal one line that
    changes, else a line every 10 s."""
    stream = sys.stderr if stream is None else stream
    due, live, shown = clock() + _PATIENCE, stream.isatty(), False
    try:
        for number, item in enumerate(items):
            now = clock()
            if now >= due:
                due, shown = now + (0.2 if live else 10.0), True
                line = f"{terminal(label)} {number:,}/{len(items):,}"
                print(f"\r{line}" if live else line, end="" if live else "\n", file=stream, flush=True)
            yield item
    finally:
        if live and shown:
            print("\r\x1b[K", end="", file=stream, flush=True)


def duration(seconds: float) -> str:
    """1:02:03 or 2:03."""
    whole = math.ceil(seconds)
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


def _figures(best: Sequence[float]) -> str:
    known = [value for value in best if not math.isnan(value)]
    if not known:
        return "none yet"
    return f"mean {sum(known) / len(known):.3f} max {max(known):.3f}"
