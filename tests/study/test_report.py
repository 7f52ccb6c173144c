"""The report as a whole: what it writes, that it writes the same again, and that partial results are told as such."""

import csv
import io
import json

import pytest

from slcs2_jax import __version__, cli
from slcs2_jax.commands import report as command
from slcs2_jax.config import InputError
from slcs2_jax.study.report import write_report

pytest.importorskip("matplotlib")


@pytest.fixture
def runs(make):
    for seed in range(3):
        for cell in ("open_short", "urban_short"):
            make.evolved("slcs2", cell, seed, [0.1 * seed, 0.2 * seed + 0.3], fresh=0.2 * seed)
        make.evolved("ailta", "open_short", seed, [-0.5, 0.1 * seed - 0.5], fresh=-0.5)
    make.evolved("ailta", "urban_short", 0, [-0.5], planned=2)
    return make.root


def test_what_is_written_and_that_it_is_the_same_again(runs, tmp_path):
    first = write_report(runs, tmp_path / "a")
    second = write_report(runs, tmp_path / "b")
    names = sorted(path.name for path in first.folder.iterdir())
    assert names == [
        "contributions_best.png",
        "contributions_best.svg",
        "contributions_best_comparisons.csv",
        "contributions_curves.png",
        "contributions_curves.svg",
        "contributions_curves_by_env_steps.png",
        "contributions_curves_by_env_steps.svg",
        "contributions_curves_by_episodes.png",
        "contributions_curves_by_episodes.svg",
        "contributions_failures.csv",
        "contributions_fitness.csv",
        "contributions_fresh_comparisons.csv",
        "contributions_report.md",
        "report.md",
        "runs.csv",
        "tables.tex",
        "verdicts.json",
        "verdicts.md",
    ]
    for name in names:
        assert (first.folder / name).read_bytes() == (second.folder / name).read_bytes(), name
        assert (first.folder / name).stat().st_size > 50


def test_partial_results_are_told(runs):
    text = (write_report(runs).folder / "report.md").read_text()
    assert "Compared after 1 generations of every run; the longest has 2." in text
    assert "- no novelty (AILTA), short urban: no run (seeds 1, 2)" in text
    assert "- no runs at all: short jammed," in text
    page = (runs / "report" / "contributions_report.md").read_text()
    assert "- no runs at all: short jammed," in page
    assert "short overall" not in page
    # the sentence names its condition, and where the runs come from
    assert f"slcs2_jax {__version__}" in text
    assert "Devices: 1 x cpu." in text


def test_more_generations_leave_out_what_has_fewer(runs):
    report = write_report(runs, generations=2)
    rows = json.loads((report.folder / "verdicts.json").read_text())
    novelty = next(row for row in rows if row["id"] == "novelty" and row["metric"] == "best")
    known = {one["place"]: one["count"] for one in novelty["evidence"]}
    assert (known["open_short"], known["urban_short"], known["open_long"]) == (3, 0, 0)
    assert novelty["verdict"] == "not enough data"


def test_an_older_report_is_replaced(runs):
    place = write_report(runs).folder
    (place / "mine.png").write_text("mine")
    assert (place / "contributions_curves.png").exists()
    older = [place / name for name in ("grammars_fresh.svg", "grammars_report.md")]
    for path in older:
        path.write_text("of runs that are no longer there")
    write_report(runs)
    assert not [path for path in older if path.exists()]
    assert (place / "mine.png").exists()
    assert (place / "contributions_curves.png").exists()


def test_verdicts_name_their_rule(runs):
    report = write_report(runs)
    for row in json.loads((report.folder / "verdicts.json").read_text()):
        assert row["rule"].startswith("holds:")
        assert row["verdict"] in ("holds", "holds in direction", "does not hold", "not enough data")
    text = (report.folder / "verdicts.md").read_text()
    assert "Without novelty search (AILTA instead)" in text
    assert "*superior*: holds:" in text


def test_the_command(runs, tmp_path, capsys):
    assert command.run([str(runs), f"out={tmp_path / 'out'}", "generations=1"]) == 0
    printed = capsys.readouterr().out
    assert "missing: no novelty (AILTA), short urban: no run (seeds 1, 2)" in printed
    assert f"report {tmp_path / 'out' / 'report.md'}" in printed
    assert (tmp_path / "out" / "tables.tex").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "0 folders; accepted is slcs2 report FOLDER"),
        (["a", "b"], "2 folders"),
        (["--all"], "option=--all: accepted is --help, or option=value"),
        (["runs", "generation=3"], "setting=generation: accepted is one of replays, deployment, out, generations"),
        (["runs", "generations=0"], "generations=0: accepted is a whole number >= 1"),
        (["nowhere"], "folder=nowhere: no such folder"),
    ],
)
def test_bad_input_is_one_line(arguments, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=says) as error:
        command.run(arguments)
    assert "\n" not in str(error.value)


def test_a_place_that_cannot_be_written_to(runs, tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match=r"out=.*file: cannot be written"):
        write_report(runs, tmp_path / "file")
    assert (tmp_path / "file").read_text() == "mine"


def test_a_single_run(make):
    make.evolved("slcs2", "open_short", 0, [0.1, 0.2], fresh=0.1)
    report = write_report(make.root / "slcs2" / "open_short" / "seed_000")
    assert "| short open | SLCS2 |" in " ".join((report.folder / "runs_report.md").read_text().split())


ODD = (
    "=cmd|' C calc'!A0",
    "\\input{secret}",
    "<script>x<!script>",
    "[l](javascript:x)",
    "\x1b[2Jx",
    "@SUM(1)",
    "$x^{$",
    "名",
)


def test_names_from_strangers_stay_text(make, capsys):
    make.evolved("slcs2", "open_short", 0, [0.5])
    for name in ODD:
        make.evolved("slcs2", "open_short", 0, [0.25], grammar=f"a/{name}.bnf")
    command.report_on(str(make.root))
    assert all(letter.isprintable() or letter == "\n" for letter in capsys.readouterr().out)
    place = make.root / "report"
    tables = [io.StringIO(file.read_bytes().decode(), newline="") for file in place.glob("*.csv")]
    cells = [cell for table in tables for row in csv.reader(table) for cell in row]
    assert "'=cmd|' C calc'!A0" in cells
    assert not [cell for cell in cells if cell.startswith(("=", "@"))]
    latex = (place / "tables.tex").read_text()
    assert r"\textbackslash{}input\{secret\}" in latex
    assert r"\$x\textasciicircum{}\{\$" in latex
    assert "\\input{" not in latex
    text = "".join(path.read_text() for path in place.glob("*report.md"))
    assert "\\<script>" in text
    assert "[l\\](javascript:x)" in text
    assert "=cmd\\|' C calc'!A0" in text
    assert "\x1b" not in text + latex


def test_what_is_passed_over_is_said_and_may_be_a_failure(runs, tmp_path, capsys):
    assert cli.main(["report", str(runs), "replays=0", "strict=on"]) == 0
    assert "passed over" not in capsys.readouterr().err
    (runs / "linked").symlink_to(tmp_path)
    assert cli.main(["report", str(runs), "replays=0"]) == 0
    assert f"passed over: {runs / 'linked'}: is a link to a folder" in capsys.readouterr().err
    assert cli.main(["report", str(runs), "replays=0", "strict=on"]) == 3


def test_a_report_folder_that_is_a_link_is_not_written_to(runs, tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "x_best.png").write_text("mine")
    (runs / "report").symlink_to(mine)
    with pytest.raises(InputError, match="its folder report is a link; accepted is a folder"):
        write_report(runs)
    assert [(path.name, path.read_text()) for path in mine.iterdir()] == [("x_best.png", "mine")]


def test_a_sweep_that_has_not_begun_in_a_world_is_reported(make):
    for speed, jammed in ((2.0, [0.1, 0.2]), (4.0, [])):
        other = type(make)(make.root / f"{speed}")
        for cell, best in (("open_short", [0.1, 0.3]), ("jammed_short", jammed)):
            other.evolved("slcs2", cell, 0, best, planned=2, swarm={"speed": speed})
    place = write_report(make.root).folder
    assert (place / "sweep_curves.png").exists()
    assert (place / "sweep_curves_by_env_steps.png").exists()
