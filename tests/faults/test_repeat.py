"""slcs2 repeat: a run is made again from what its folder records; and the commands as people call them."""

from __future__ import annotations

import shutil

import pytest

from slcs2_jax import cli
from slcs2_jax.config import Rules
from slcs2_jax.grammar import load_grammar
from slcs2_jax.results.rows import parse_row, row_line
from slcs2_jax.results.run_config import RunConfig, read_config, write_config
from slcs2_jax.running import driver


def test_a_repeated_run_comes_to_the_same(tiny_run, finished, tmp_path, capfd):
    assert cli.main(["repeat", str(finished), f"into={tmp_path / 'again'}"]) == 0
    out = capfd.readouterr().out
    assert out.endswith("it came to the same\n")
    assert "solutions/instance_001_best.npz" in out
    assert tiny_run.results(tmp_path / "again") == tiny_run.results(finished)


def test_what_differs_is_named(finished, tmp_path, capfd):
    copy = tmp_path / "copy"
    shutil.copytree(finished, copy)
    (copy / "solutions" / "instance_000_best.txt").write_text("nothing\n")
    lines = (copy / "generations.jsonl").read_bytes().splitlines(keepends=True)
    (copy / "generations.jsonl").write_bytes(b"".join([*lines[:3], b"{}\n", *lines[4:]]))
    (copy / "solutions" / "instance_000_member_099.npz").touch()
    assert cli.main(["repeat", str(copy)]) == 3
    out = capfd.readouterr().out
    assert "generations.jsonl                        DIFFERS, first in line 4\n" in out
    assert "solutions/instance_000_best.txt          DIFFERS\n" in out
    assert "instance_000_member_099.npz    not in the repeated run\n" in out
    assert out.endswith("3 files differ\n")


def test_files_that_were_not_kept_are_no_difference(finished, tmp_path, capfd):
    copy = tmp_path / "copy"
    shutil.copytree(finished, copy)
    gone = [copy / "checkpoint.npz", *(copy / "solutions").glob("*_member_*")]
    for file in gone:
        file.unlink()
    assert cli.main(["repeat", str(copy)]) == 0
    assert f"\n{len(gone)} further files are only in the repeated run\nit came to the same\n" in capfd.readouterr().out


def test_columns_that_were_not_kept_are_no_difference_others_are(finished, tmp_path, capfd):
    copy = tmp_path / "copy"
    shutil.copytree(finished, copy)
    rows = [parse_row(line) for line in (copy / "generations.jsonl").read_bytes().splitlines()]
    for row in rows:
        del row["contribution"]
    (copy / "generations.jsonl").write_bytes(b"".join(map(row_line, rows)))
    assert cli.main(["repeat", str(copy)]) == 0
    assert (
        "generations.jsonl                        same, but for contribution, which is not there\n"
        in capfd.readouterr().out
    )
    rows[2]["copied"] += 1
    (copy / "generations.jsonl").write_bytes(b"".join(map(row_line, rows)))
    assert cli.main(["repeat", str(copy)]) == 3
    assert "generations.jsonl                        DIFFERS, first in line 3\n" in capfd.readouterr().out


def test_a_grammar_that_is_gone_is_no_hindrance(tiny_run, tmp_path, capfd):
    file = tmp_path / "mine.bnf"
    file.write_text(load_grammar("main").text)
    driver.evolve([tiny_run.settings(tmp_path / "run", rules=Rules(rules=6, grammar=str(file)))])
    file.write_text("<Rule> ::= <Rule>\n")
    assert cli.main(["repeat", str(tmp_path / "run")]) == 0


def test_other_versions_are_said(finished, tmp_path, capfd):
    copy = tmp_path / "copy"
    shutil.copytree(finished, copy)
    config = read_config(copy)
    record = config.record | {"versions": config.record["versions"] | {"jax": "0.1"}}
    write_config(copy, RunConfig(config.settings, record))
    cli.main(["repeat", str(copy)])
    assert "jax was 0.1 and is " in capfd.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ([], "repeat: accepted is slcs2 repeat FOLDER"),
        (["{0}/absent"], "absent/config.yaml: not the configuration of a run"),
        (["{0}/begun"], "is not finished; accepted is a finished run (slcs2 resume"),
        (["{0}/finished", "into={0}/begun"], "begun: already holds a run"),
        (["{0}/finished", "seed=3"], "setting=seed: accepted is one of into"),
    ],
)
def test_what_cannot_be_repeated(arguments, part, tiny_run, finished, tmp_path, capfd):
    shutil.copytree(finished, tmp_path / "finished")
    shutil.copytree(finished, tmp_path / "begun")
    (tmp_path / "begun" / "summary.json").unlink()
    assert cli.main(["repeat", *(one.format(tmp_path) for one in arguments)]) == 2
    assert part in capfd.readouterr().err


def test_resume_from_the_command_line(tiny_run, finished, tmp_path, capfd):
    for name in ("a", "b/c"):
        driver.evolve([tiny_run.settings(tmp_path / name, generations=1)])
    assert cli.main(["resume", str(tmp_path), "generations=3"]) == 0
    out, _ = capfd.readouterr()
    for name in ("a", "b/c"):
        assert f"run folder {tmp_path / name}\n" in out
        assert tiny_run.results(tmp_path / name) == tiny_run.results(finished)
    assert cli.main(["resume", str(tmp_path)]) == 0
    assert "2 of the runs are finished\n" in capfd.readouterr().err
