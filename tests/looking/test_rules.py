"""slcs2 rules: finished runs, runs under way, saved solutions, and one line for any bad input."""

from __future__ import annotations

import json

import pytest

from slcs2_jax import cli


def test_it_prints_and_writes_what_is_asked_for(finished, tmp_path, capsys):
    assert cli.main(["rules", str(finished), "instance=1", "top=2", "agent=2"]) == 0
    shown = capsys.readouterr()
    assert "agent 2" in shown.out
    assert "agent 1   " not in shown.out
    assert "matched  chosen" in shown.out
    assert shown.err == ""
    out = tmp_path / "rules.json"
    assert cli.main(["rules", str(finished), "format=json", "replay=off", f"out={out}"]) == 0
    document = json.loads(out.read_text())
    assert len(document["rules"]) == 3 * 12
    assert {rule["chosen"] for rule in document["rules"]} == {None}
    solution = finished / "solutions" / "instance_001_best.npz"
    assert cli.main(["rules", str(solution), "format=csv", "replay=off"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2 + 3 * 12  # the line about the file before


def test_a_run_under_way_says_so(under_way, capsys):
    assert cli.main(["rules", str(under_way), "replay=off"]) == 0
    shown = capsys.readouterr()
    assert "has not ended: 4 of 4 generations" in shown.err
    assert "agent 2" in shown.out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "accepted is slcs2 rules RUN"),
        (["nowhere"], "run=nowhere: holds no run"),
        (["RUN", "member=99"], "member=99: accepted is best, or a number from 0"),
        (["RUN", "instance=2"], "instance=2: accepted is a whole number from 0 to 1"),
        (["RUN", "agent=3"], "agent=3: accepted is all, or a number from 0 to 2"),
        (["RUN", "top=-1"], "top=-1: accepted is a whole number >= 0"),
        (["RUN", "sort=size"], "sort=size: accepted is one of strength, use, quality"),
        (["RUN", "format=xml"], "format=xml: accepted is one of text, csv, json"),
        (["RUN", "replay=maybe"], "replay=maybe: accepted is on or off"),
        (["RUN", "colour=red"], "option=colour: accepted is one of instance,"),
        (["RUN", "out=EXISTS"], "exists; accepted is a new file"),
        (["RUN", "out=nowhere/rules.txt"], "there is no folder nowhere"),
    ],
)
def test_bad_input_gets_one_line(arguments, says, finished, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").write_text("mine")
    arguments = [one.replace("RUN", str(finished)).replace("EXISTS", "there") for one in arguments]
    assert cli.main(["rules", *arguments]) == 2
    line = capsys.readouterr().err
    assert says in line
    assert line.count("\n") == 1
    assert (tmp_path / "there").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 1
