"""slcs2 replay suite=WORLD: two entries in the same frozen world."""

from __future__ import annotations

import csv

import pytest

from slcs2_jax import cli


def test_two_entries_are_shown_in_one_world(in_use, tmp_path, capsys):
    out = tmp_path / "both.csv"
    call = ["replay", "designed", "suite=few", "beside=relay_chain", "end=30", f"out={out}"]
    assert cli.main(call) == 0
    shown = capsys.readouterr().out
    seed = in_use.worlds["few"].seeds_of("validation")[0]
    assert f"The designed behaviour in few, seed {seed}, the first 30 steps" in shown
    assert f"Relay chain in few, seed {seed}, the first 30 steps" in shown
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len({next(iter(row.values())) for row in rows}) == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["suite=few"], "accepted is slcs2 replay ENTRY suite=WORLD"),
        (["designed", "suite=few", "policy=designed"], "accepted is slcs2 replay ENTRY suite=WORLD"),
        (["designed", "suite=moon"], "world=moon: accepted is one of"),
        (["designed", "suite=few", "swarm.speed=3"], "setting=swarm.speed: accepted is seed"),
        (["designed", "suite=few", "seed=1"], "seed=1: accepted is one of"),
        (["slcs2", "suite=few", "training=1"], "has no artefact of training 1"),
    ],
)
def test_bad_input_is_one_line(in_use, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["replay", *arguments, "end=10", "out=x.csv"]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
