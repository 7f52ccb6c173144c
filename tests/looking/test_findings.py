"""What winners do, in words: counted from what a solution learnt and what its reflexes are."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.looking.findings import acting_shares, findings, group_words, in_words, reflex_shares
from slcs2_jax.looking.page_data import Shown, figures
from tests.running.test_informed import settings


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("found") / "run"
    slcs2.evolve(settings(folder))
    return slcs2.read_run(folder)


def changed(solution, *, flags: np.ndarray, usage: np.ndarray):
    rules = dataclasses.replace(solution.rules, reflex=flags)
    return dataclasses.replace(solution, rules=rules, usage=usage)


def test_reflexes_and_acts_are_counted(run):
    best = run.best(0)
    flags, usage = np.zeros((3, 14), bool), np.zeros((3, 14), np.int32)
    flags[:, 0], flags[0, 1] = True, True
    usage[:, 0], usage[1, 13], usage[2, 12], usage[1, 1] = 10, 50, 6, 14  # of 100
    found = findings(changed(best, flags=flags, usage=usage), run, 0)
    assert list(found.reflexes.values()) == [1.0, 1 / 3] + [0.0] * 8
    assert found.by_reflex == pytest.approx(0.3)
    first = next(iter(found.acting.items()))
    assert first == (best.rules.text(1, 13), 0.5)
    assert found.acting[best.rules.text(1, 1)] == pytest.approx(0.14)  # not a reflex of that agent
    words = " ".join(in_words(found, 3))
    assert f"Reflexes in every agent: {best.rules.text(0, 0)}." in words
    assert f"In some agents: {best.rules.text(0, 1)} (1 of 3)." in words
    assert "Reflexes did 30% of all that was done" in words


def test_packets_travel_as_the_row_says(run):
    best = run.best(0)
    row = next(row for row in run.rows if (row["instance"], row["generation"]) == (0, best.generation))
    found = findings(best, run, 0)
    assert found.delivered == row["delivered"] > 0
    assert found.carriers == pytest.approx(sum(row["contribution"]) / row["delivered"])
    shares = np.array(row["contribution"]) / sum(row["contribution"])
    assert found.carrying == pytest.approx(1 / (shares**2).sum())
    assert findings(best).carriers is None  # without its row


def test_a_group_is_told_of_together(run):
    several = [findings(run.best(number), run, number) for number in range(2)]
    shares = reflex_shares(several)
    text = next(iter(shares))
    assert shares[text] == pytest.approx(np.mean([one.reflexes[text] for one in several]))
    first, share, count = acting_shares(several)[0]
    assert share == pytest.approx(sum(one.acting.get(first, 0) for one in several) / 2)
    assert 1 <= count <= 2
    assert any(line.startswith("Switched off in most agents") for line in group_words(several))


def test_without_reflexes_nothing_is_said_of_them(run):
    best = run.best(0)
    plain = dataclasses.replace(best, rules=dataclasses.replace(best.rules, reflex=None))
    found = findings(plain, run, 0)
    assert (found.reflexes, found.by_reflex) == ({}, 0.0)
    assert not any("eflex" in line for line in in_words(found, 3))


def test_the_page_of_a_run_says_it(run):
    shown = Shown(run=run, instance=0, solution=run.best(0))
    assert figures(shown)["found"] == in_words(findings(run.best(0), run, 0), 3)
    assert figures(Shown(run=run, instance=0))["found"] == []


def test_the_command_tells_of_all_runs(run, tmp_path, capfd):
    assert cli.main(["found", str(run.path.parent)]) == 0
    out = capfd.readouterr().out
    assert out.startswith("# What evolution found\n")
    assert "### Short open (2 winners)" in out
    assert "| reflex | short open |" in out
    file = tmp_path / "found.md"
    assert cli.main(["found", str(run.path.parent), f"out={file}"]) == 0
    assert file.read_text() == out
    capfd.readouterr()
    for line, says in (
        (["found", str(run.path.parent), f"out={file}"], "exists; accepted is a new file"),
        (["found", str(run.path.parent), "arm=mine"], "of arm=mine; there are informed_2_starts"),
        (["found", str(tmp_path)], "holds no finished run of evolution"),
    ):
        assert cli.main(line) == 2
        assert says in capfd.readouterr().err
