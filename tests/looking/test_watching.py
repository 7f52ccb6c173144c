"""Runs of another process, read while they grow."""

from __future__ import annotations

import json
import os
import shutil
import socket

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.results.lock import LOCK, FolderLock, is_held
from slcs2_jax.results.rows import append_rows, read_rows
from slcs2_jax.results.run_folder import CHECKPOINT, GENERATIONS, SUMMARY
from slcs2_jax.results.sweep import write_sweep
from slcs2_jax.results.watching import RESCAN, Watcher, state_of


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def growing(finished, tmp_path):
    """A folder with a run of which no row is written yet, and its rows."""
    run = tmp_path / "root" / "open_short" / "seed_000"
    shutil.copytree(finished, run)
    rows = read_rows(run / GENERATIONS)
    for name in (GENERATIONS, SUMMARY, CHECKPOINT):
        (run / name).unlink()
    return run, rows


def test_rows_are_counted_as_they_come(growing, tmp_path):
    run, rows = growing
    clock = Clock()
    watcher = Watcher(tmp_path / "root", clock)
    assert (watcher.done, watcher.planned, watcher.pace, watcher.finished) == (0, 8, None, False)
    for at, part in enumerate((rows[:2], rows[2:4], rows[4:6])):
        clock.now = 110.0 + 10 * at
        append_rows(run / GENERATIONS, part)
        watcher.look()
        assert watcher.done == 2 * (at + 1)
        assert (watcher.pace is None) == (at == 0), "the first rows tell no pace: nobody knows when their work began"
    assert watcher.pace.generations == pytest.approx(4 / 20)
    own = rows[2:6]
    assert watcher.pace.evaluations == pytest.approx(sum(row["deployments"] for row in own) / 20)
    assert watcher.pace.env_steps == pytest.approx(sum(row["deployments"] * row["steps"] for row in own) / 20)
    [(name, [one])] = watcher.groups().items()
    assert name == "open_short"
    assert one.best == {
        instance: max(row["best"] for row in rows[:6] if row["instance"] == instance) for instance in (0, 1)
    }


def test_half_a_row_waits_for_its_other_half_and_a_cut_file_is_read_anew(growing, tmp_path):
    run, rows = growing
    append_rows(run / GENERATIONS, rows[:3])
    whole = (run / GENERATIONS).read_bytes()
    (run / GENERATIONS).write_bytes(whole[:-7])
    watcher = Watcher(tmp_path / "root")
    assert watcher.done == 2
    with (run / GENERATIONS).open("ab") as file:
        file.write(whole[-7:])
    watcher.look()
    assert watcher.done == 3
    (run / GENERATIONS).write_bytes(whole[: whole.index(b"\n") + 1])
    watcher.look()
    assert (watcher.done, watcher.runs[0].evaluations) == (1, rows[0]["deployments"])
    (run / GENERATIONS).write_bytes(b"{}\n")
    with pytest.raises(InputError, match=r"generations.jsonl: .*; slcs2 resume .* says what can be done"):
        Watcher(tmp_path / "root")


def test_what_a_run_is_doing(growing, finished, tmp_path):
    run, _ = growing
    watcher = Watcher(tmp_path / "root")
    assert state_of(watcher.runs) == "interrupted"
    with FolderLock(run):
        watcher.look()
        assert (state_of(watcher.runs), watcher.working) == ("running", True)
    shutil.copy(finished / GENERATIONS, run)
    shutil.copy(finished / SUMMARY, run)
    watcher.look()
    assert (state_of(watcher.runs), watcher.finished, watcher.done) == ("finished", True, 8)


def test_runs_that_come_later_and_runs_not_begun_are_found(growing, tmp_path):
    run, _ = growing
    clock = Clock()
    watcher = Watcher(tmp_path / "root", clock)
    other = run.parent / "seed_002"
    settings = watcher.runs[0].settings
    write_sweep(tmp_path / "root", [settings.__class__(**{**vars(settings), "run_dir": str(other)})])
    watcher.look()
    assert len(watcher.runs) == 1
    clock.now += RESCAN
    watcher.look()
    assert [one.begun for one in watcher.runs] == [True, False]
    assert state_of(watcher.runs[1:]) == "waiting"
    assert watcher.planned == 16


@pytest.mark.parametrize(
    ("owner", "held"),
    [
        ({"host": "HERE", "pid": os.getpid()}, True),
        ({"host": "HERE", "pid": 2**22 + 1}, False),
        ({"host": "HERE", "pid": 10**30}, True),
        ({"host": "elsewhere", "pid": 1}, True),
        ({"host": "HERE"}, False),
        ([], False),
    ],
)
def test_a_lock_tells_whether_its_process_lives(owner, held, tmp_path):
    (tmp_path / LOCK).write_text(json.dumps(owner).replace("HERE", socket.gethostname()))
    assert is_held(tmp_path) == held
    (tmp_path / LOCK).unlink()
    assert not is_held(tmp_path)
