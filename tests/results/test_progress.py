"""Progress: lines where there is no terminal, a bar where there is one."""

import io
import math

import pytest

from slcs2_jax.results import InstanceSummary, Progress
from slcs2_jax.results.progress import duration


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_line_per_generation_of_the_slowest_instance():
    clock, stream = Clock(), io.StringIO()
    with Progress(10, stream=stream, clock=clock) as report:
        report.note("compiling")
        clock.now += 10
        report.generation(done=[1, 0], best=[0.5, math.nan], evaluations=1, env_steps=20_000)
        report.generation(done=[1, 1], best=[0.5, -0.1], evaluations=2, env_steps=40_000)
        clock.now += 10
        report.generation(done=[2, 2], best=[0.5, 0.1], evaluations=6, env_steps=120_000)
    lines = stream.getvalue().splitlines()
    assert lines == [
        "compiling",
        "generation 1/10  best mean 0.200 max 0.500  0.2 evaluations/s  4,000 env-steps/s  1:30 left",
        "generation 2/10  best mean 0.300 max 0.500  0.3 evaluations/s  6,000 env-steps/s  0:54 left",
    ]


def test_nothing_known_yet():
    stream = io.StringIO()
    with Progress(1, stream=stream) as report:
        report.generation(done=[1], best=[math.nan], evaluations=0, env_steps=0)
    assert "none yet" in stream.getvalue()
    assert "0:00 left" in stream.getvalue()


def test_a_bar_on_a_terminal(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    with Progress(3, stream=stream) as report:
        report.generation(done=[3, 3], best=[0.5, 0.25], evaluations=6, env_steps=10)
    assert "generation 3/3" in stream.getvalue()


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00"), (59.2, "1:00"), (3723, "1:02:03")])
def test_duration(seconds, text):
    assert duration(seconds) == text


def test_a_summary_takes_no_nan():
    with pytest.raises(ValueError, match="fresh_mean=nan"):
        InstanceSummary(
            seed=0, generations=1, best_fitness=0.1, fresh_mean=math.nan, fresh_sd=0.0, evaluations=1, env_steps=1
        )
