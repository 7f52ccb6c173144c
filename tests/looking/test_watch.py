"""slcs2 watch on a terminal, without one, and on bad input."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import sys
import threading
import time

import pytest

from slcs2_jax import cli
from slcs2_jax.commands import watch
from slcs2_jax.results.rows import append_rows, read_rows
from slcs2_jax.results.run_folder import GENERATIONS


def test_one_look_gives_a_table(finished, capsys):
    assert cli.main(["watch", str(finished.parent), "once=on"]) == 0
    shown = capsys.readouterr().out
    assert "8/8" in shown
    assert "100%" in shown
    assert "1 of 1 runs have ended, 8 of 8 generations" in shown


@pytest.mark.parametrize("name", ["[/red]", "\x1b[2J", "a\nb"])
def test_names_of_folders_are_text(name, finished, tmp_path, capsys):
    shutil.copytree(finished, tmp_path / name / "run")
    assert cli.main(["watch", str(tmp_path), "once=on"]) == 0
    shown = capsys.readouterr().out
    assert ascii(name)[1:-1] in shown
    assert all(letter.isprintable() or letter == "\n" for letter in shown)


def test_it_looks_until_all_have_ended(finished, capsys):
    assert cli.main(["watch", str(finished)]) == 0
    assert capsys.readouterr().out.endswith(" 1 of 1 runs have ended, 8 of 8 generations\n")


def test_rows_that_come_are_told(under_way, monkeypatch, capsys):
    rows = read_rows(under_way / GENERATIONS)
    (under_way / GENERATIONS).unlink()
    append_rows(under_way / GENERATIONS, rows[:2])
    looks = iter([rows[2:4], rows[4:6]])

    def sleep(seconds: float) -> None:
        assert seconds == 7
        part = next(looks, None)
        if part is None:
            raise KeyboardInterrupt
        append_rows(under_way / GENERATIONS, part)

    monkeypatch.setattr(watch.time, "sleep", sleep)
    assert cli.main(["watch", str(under_way), "every=7"]) == 0
    told = [line.split(" ", 1)[1] for line in capsys.readouterr().out.splitlines() if line]
    assert told == [f"0 of 1 runs have ended, {done} of 8 generations, no process works on them" for done in (2, 4, 6)]


def test_on_a_terminal_the_table_stands_still(finished):
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "slcs2_jax", "watch", str(finished)]
    seen = b""

    def read() -> None:
        nonlocal seen
        while True:
            try:
                part = os.read(ours, 4096)
            except OSError:
                return
            if not part:
                return
            seen += part

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    process = subprocess.run(command, stdout=theirs, stderr=theirs, timeout=60, check=False)
    time.sleep(0.2)
    os.close(theirs)
    reader.join(5)
    assert process.returncode == 0
    assert b"finished" in seen
    assert b"8 of 8 generations" in seen


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere"], "folder=nowhere: no such folder"),
        (["EMPTY"], "holds no run"),
        ([], "watch: 0 folders; accepted is slcs2 watch FOLDER"),
        (["RUN", "every=0"], "every=0: accepted is a whole number of seconds from 1 to 3600"),
        (["RUN", "every=soon"], "every=soon: accepted is a whole number"),
        (["RUN", "once=maybe"], "once=maybe: accepted is on or off"),
        (["RUN", "colour=red"], "option=colour: accepted is one of every, once"),
    ],
)
def test_bad_input_gets_one_line(arguments, says, finished, tmp_path, capsys):
    names = {"RUN": str(finished), "EMPTY": str(tmp_path)}
    assert cli.main(["watch", *(names.get(one, one) for one in arguments)]) == 2
    line = capsys.readouterr().err
    assert says in line
    assert line.count("\n") == 1
