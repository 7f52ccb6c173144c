"""slcs2 transfer: winners of all runs in a folder in other worlds, begun again where it was stopped; and bad input."""

from __future__ import annotations

import csv
import dataclasses
import shutil

import pytest

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.results.rows import read_rows, row_line
from tests.running.test_informed import settings


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    root = tmp_path_factory.mktemp("runs")
    near = {"generations": 5, "fresh_deployments": 1}
    slcs2.evolve(settings(root / "special", **near))
    wide = settings(root / "general", **near)
    slcs2.evolve(dataclasses.replace(wide, worlds=("open/0..1", "urban/0..1"), instances=1))
    plain = settings(root / "plain", inherit_quality=False, **near)
    slcs2.evolve(
        dataclasses.replace(plain, world=dataclasses.replace(plain.world, environment="urban", buildings=True))
    )
    return root


WORLDS = "worlds=[open/900..902, urban/900..901]"


def test_a_matrix_of_all_sources(runs, capfd):
    line = ["transfer", str(runs), WORLDS, "deployments=2", "compute.devices=1"]
    assert cli.main(line) == 0
    out = capfd.readouterr().out
    rows = list(csv.DictReader((runs / "transfer" / "matrix.csv").read_text().splitlines()))
    told = [(row["what"], row["inherited quality"], row["winners"]) for row in rows]
    assert told == [
        ("specialist", "", "2"),
        ("specialist", "kept", "2"),
        ("specialist", "forgotten", "2"),
        ("generalist", "kept", "1"),
        ("generalist", "forgotten", "1"),
        ("behaviour", "", "1"),
    ]
    assert rows[3]["evolved in"] == "4 worlds, informed 2 starts"
    assert "designed" in out
    for name in ("transfer.md", "contests.csv", "tables.tex", "transfer.png", "transfer.svg"):
        assert (runs / "transfer" / name).is_file()
    before = (runs / "transfer" / "matrix.csv").read_bytes(), (runs / "transfer" / "deployments.jsonl").read_bytes()
    assert cli.main(line) == 0
    assert before == (
        (runs / "transfer" / "matrix.csv").read_bytes(),
        (runs / "transfer" / "deployments.jsonl").read_bytes(),
    )


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["worlds=[open/short/1]"], "worlds=open/short/1: accepted is worlds not seen in "),
        (["worlds=[open/1]"], "worlds=open/short/1: accepted is worlds not seen in "),
        (["worlds=[lunar/1]"], "worlds=lunar/1: accepted is environments"),
        (["worlds=open"], "worlds=open: accepted is a list of ENVIRONMENT/RANGE/SEEDS"),
        (["deployments=0"], "deployments=0: accepted is a whole number from 1 to 100"),
        (["policy=nobody"], "policy 'nobody': there is no such policy or file"),
        (["seed=3"], "setting=seed: accepted is one of worlds, deployments"),
    ],
)
def test_bad_input_is_one_line(runs, arguments, says, capfd):
    assert cli.main(["transfer", str(runs), *arguments]) == 2
    [line] = [line for line in capfd.readouterr().err.splitlines() if line.startswith("slcs2: error")]
    assert says in line


def test_several_folders(runs, tmp_path):
    folders = [str(runs / name) for name in ("general", "special")]
    assert cli.main(["transfer", *folders, "worlds=[open/900]", f"out={tmp_path}", "compute.devices=1"]) == 0
    rows = list(csv.DictReader((tmp_path / "matrix.csv").read_text().splitlines()))
    assert [row["what"] for row in rows] == ["specialist"] * 2 + ["generalist"] * 2 + ["behaviour"]


def test_a_folder_without_runs(tmp_path, capfd):
    assert cli.main(["transfer", str(tmp_path)]) == 2
    assert "accepted is a folder with finished runs of evolution" in capfd.readouterr().err


LINE = ["worlds=[open/900]", "compute.devices=1"]


def test_nothing_is_written_behind_a_link(runs, tmp_path, capfd):
    (tmp_path / "outside").mkdir()
    shutil.copytree(runs / "special", tmp_path / "special")
    (tmp_path / "special" / "transfer").symlink_to(tmp_path / "outside")
    assert cli.main(["transfer", str(tmp_path / "special"), *LINE]) == 2
    assert "special/transfer: " in capfd.readouterr().err
    assert not any((tmp_path / "outside").iterdir())


def test_figures_of_other_counts_are_not_believed(runs, tmp_path, capfd):
    call = ["transfer", str(runs / "special"), f"out={tmp_path}", *LINE]
    assert cli.main(call) == 0
    file = tmp_path / "deployments.jsonl"
    rows = [row | {"fitness": [0.5, 0.5]} for row in read_rows(file)]
    file.write_bytes(b"".join(map(row_line, rows)))
    capfd.readouterr()
    assert cli.main(call) == 2
    assert "deployments.jsonl: figures of more or fewer deployments" in capfd.readouterr().err
