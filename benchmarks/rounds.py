"""Repeats: everybody plays once in every round, so that what disturbs the machine disturbs all alike."""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

CLOCKS = {"wall": time.perf_counter, "cpu": time.process_time}


class Clock:
    """What time is measured with: the wall's, or the processor's, which a busy machine disturbs less.

    `cpu` adds up what all threads of this process take, so its rates are those of a core.
    """

    def __init__(self) -> None:
        """The wall's."""
        self.name = "wall"

    def now(self) -> float:
        """Seconds since some time."""
        return CLOCKS[self.name]()


clock = Clock()


@dataclass(frozen=True)
class Play:
    """One measured stretch.

    Attributes:
        seconds: by the `clock`.
        steps: time-steps of running episodes that were made in it.
        slot_steps: time-steps computed, those of vacant slots and of episodes that are over included.
        lengths: steps of the episodes that were played to their end.
    """

    seconds: float
    steps: int
    slot_steps: int
    lengths: tuple[int, ...]

    @property
    def rate(self) -> float:
        """Useful env-steps per second."""
        return self.steps / self.seconds


@dataclass(frozen=True)
class Spread:
    """Median, least and greatest of the repeats."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Of at least one value."""
        return cls(statistics.median(values), min(values), max(values))

    def as_dict(self) -> dict[str, float]:
        """For JSON."""
        return dataclasses.asdict(self)


def interleave(contestants: Mapping[str, Callable[[], Play]], repeats: int) -> dict[str, list[Play]]:
    """Let everybody play once per round, in every second round in the opposite order."""
    plays: dict[str, list[Play]] = {name: [] for name in contestants}
    for number in range(repeats):
        order = list(contestants)
        for name in order if number % 2 == 0 else reversed(order):
            plays[name].append(contestants[name]())
    return plays


def ratios(plays: Sequence[Play], others: Sequence[Play]) -> Spread:
    """How many times as fast, round by round."""
    return Spread.of([one.rate / other.rate for one, other in zip(plays, others, strict=True)])
