"""When runs are saved: by the clock, within the share of the time, or by generations."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from slcs2_jax.config import Checkpoint
from slcs2_jax.running.saving import SHARE, Saver


class Clock:
    """Time that passes only when something says so."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


class Run:
    """Stands in for a run; a save takes `cost` seconds."""

    def __init__(self, clock: Clock, *, cost: float = 0.0, folder: bool = True, **checkpoint) -> None:
        self.clock, self.cost, self.saves = clock, cost, []
        self.settings = SimpleNamespace(checkpoint=Checkpoint(**checkpoint))
        self.folder = object() if folder else None
        self.summary = None
        self.progress = [(0, 0), (0, 0)]

    def save(self, seconds: float) -> None:
        self.clock.now += self.cost
        self.saves.append(seconds)

    def advance(self, first: int, second: int = 0) -> None:
        self.progress = [(first, 0), (second, 0)]


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_by_the_clock_and_only_if_there_is_something_new(clock):
    run = Run(clock, seconds=60.0)
    saver = Saver([run], clock)
    for clock.now, generation in ((59.0, 1), (60.0, 1), (90.0, 2), (121.0, 2), (200.0, 2), (300.0, 3)):
        run.advance(generation)
        saver.after_chunk()
    assert run.saves == [60.0, 121.0, 300.0]


def test_deployments_are_something_new(clock):
    run = Run(clock, seconds=10.0)
    saver = Saver([run], clock)
    run.progress = [(0, 1), (0, 0)]
    clock.now = 11.0
    saver.after_chunk()
    assert run.saves == [11.0]


def test_by_generations_of_the_fastest_instance_whatever_it_costs(clock):
    run = Run(clock, cost=100.0, generations=3, seconds=None)
    saver = Saver([run], clock)
    for generation in range(1, 10):
        run.advance(0, generation)
        saver.after_chunk()
    assert len(run.saves) == 3


def test_never(clock):
    run = Run(clock, generations=None, seconds=None)
    saver = Saver([run], clock)
    run.advance(1000)
    clock.now = 1e6
    saver.after_chunk()
    assert run.saves == []
    saver.save_all()
    assert len(run.saves) == 1
    saver.save_all()
    assert len(run.saves) == 1


def test_many_runs_take_turns_within_their_share_of_the_time(clock):
    runs = [Run(clock, cost=0.01, seconds=60.0) for _ in range(200)]
    saver = Saver(runs, clock)
    chunks = 20_000
    for chunk in range(chunks):
        clock.now += 0.1
        for run in runs:
            run.advance(chunk)
        saver.after_chunk()
    counts = [len(run.saves) for run in runs]
    assert sum(counts) * 0.01 <= SHARE * clock.now * 1.01
    assert sum(counts) * 0.01 >= SHARE * clock.now * 0.9, "slower than it might be"
    assert max(counts) - min(counts) <= 1


def test_finished_runs_and_those_without_a_folder_are_left_alone(clock):
    ended, nowhere = Run(clock, seconds=0.0), Run(clock, folder=False, generations=1)
    saver = Saver([ended, nowhere], clock)
    for run in (ended, nowhere):
        run.advance(5)
    ended.summary = object()
    clock.now = 100.0
    saver.after_chunk()
    saver.save_all()
    assert (ended.saves, nowhere.saves) == ([], [])
