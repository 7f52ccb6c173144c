"""Progress: lines where there is no terminal, a bar where there is one."""

import io
import math
import re

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
        "generation 1/10  1:30 left  best mean 0.200 max 0.500  0.2 evaluations/s  4,000 env-steps/s",
        "generation 2/10  0:54 left  best mean 0.300 max 0.500  0.3 evaluations/s  6,000 env-steps/s",
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


def last_line(stream: io.StringIO) -> str:
    """What a terminal shows last, without what moves its cursor."""
    return re.split(r"[\r\n]", re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", stream.getvalue()).strip())[-1]


@pytest.mark.parametrize("columns", ["60", "80"])
def test_a_narrow_terminal_shows_the_time_left(monkeypatch, columns):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", columns)
    clock, stream = Clock(), Terminal()
    with Progress(500, stream=stream, clock=clock) as report:
        report.generation(done=[100] * 8, best=[0.5] * 8, evaluations=1, env_steps=1)
        clock.now += 3600
        report.generation(done=[200] * 8, best=[0.5] * 8, evaluations=12_345, env_steps=123_456_789)
    assert "generation 200/500" in last_line(stream)
    assert "3:00:00 left" in last_line(stream)


@pytest.mark.parametrize("kind", [io.StringIO, Terminal])
def test_after_the_last_generation_it_says_what_goes_on(monkeypatch, kind):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    stream = kind()
    with Progress(2, stream=stream, afterwards="now fresh deployments") as report:
        report.generation(done=[2, 1], best=[0.5, 0.5], evaluations=3, env_steps=9)
        assert "now fresh" not in stream.getvalue()
        report.generation(done=[2, 2], best=[0.5, 0.5], evaluations=4, env_steps=9)
    assert "generation 2/2" in last_line(stream)
    assert "now fresh deployments" in last_line(stream)


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00"), (59.2, "1:00"), (3723, "1:02:03")])
def test_duration(seconds, text):
    assert duration(seconds) == text


def test_a_summary_takes_no_nan():
    with pytest.raises(ValueError, match="fresh_mean=nan"):
        InstanceSummary(
            seed=0, generations=1, best_fitness=0.1, fresh_mean=math.nan, fresh_sd=0.0, evaluations=1, env_steps=1
        )
