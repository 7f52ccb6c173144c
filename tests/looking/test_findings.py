"""What winners do, in words: counted from what a solution learnt and what its reflexes are."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.grammar import RuleSets, parse_rule_text
from slcs2_jax.looking.findings import Findings, acting_shares, findings, in_words, reflex_shares
from slcs2_jax.looking.found_page import in_short, page
from slcs2_jax.looking.page_data import Shown, figures
from tests.running.test_informed import settings


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("found") / "run"
    slcs2.evolve(settings(folder))
    return slcs2.read_run(folder)


RULES = ["packet held => send to si", "d_si < net => move toward sink", "d_c < net => move toward sink",
         "no packet held => orbit si"]  # fmt: skip


def saved(run, *, flags: list[list[int]], usage: list[list[int]]):
    """A solution of two agents with these four rules each, the last of one agent in place of its third."""
    rules = RuleSets.from_rules([[parse_rule_text(text) for text in RULES]] * 2)
    zeros = np.zeros((2, 4), np.float32)
    return dataclasses.replace(
        run.best(0),
        rules=dataclasses.replace(rules, reflex=np.array(flags, bool)),
        quality=zeros, strength=zeros, error=zeros,
        usage=np.array(usage, np.int32),
        contribution=np.ones(2, np.float32),
        origin_kind=None, origin_generation=None, origin_agent=None,
    )  # fmt: skip


def test_reflexes_and_acts_are_counted(run):
    found = findings(saved(run, flags=[[1, 1, 0, 0], [1, 0, 0, 0]], usage=[[10, 20, 30, 0], [0, 5, 15, 20]]))
    assert found.by_reflex == pytest.approx(30 / 75)  # where several rules take part it is one act: 10 + 30, 15 + 20
    assert found.actions == {
        "move toward sink": (pytest.approx(45 / 75), pytest.approx(25 / 75)),
        "orbit si": (pytest.approx(20 / 75), pytest.approx(20 / 75)),
        "send to si": (pytest.approx(10 / 75), 0.0),
    }
    assert found.acting == {
        RULES[2]: pytest.approx((30 - 20 + 15) / 75),  # not the acts that the reflex brought about
        RULES[3]: pytest.approx(20 / 75),
        RULES[1]: pytest.approx(5 / 75),
    }
    words = " ".join(in_words(found, 2))
    assert "Reflexes did 40% of all that was done" in words


def test_a_rule_that_an_agent_has_twice_acts_once(run):
    solution = saved(run, flags=[[0, 0, 0, 0]] * 2, usage=[[0, 7, 7, 0], [0, 0, 0, 3]])
    twice = RuleSets.from_rules([[parse_rule_text(RULES[place]) for place in (0, 1, 1, 3)]] * 2)
    assert findings(dataclasses.replace(solution, rules=twice)).acting == {RULES[1]: 0.7, RULES[3]: 0.3}


def test_reflexes_are_told_by_how_many_agents_have_them(run):
    best = run.best(0)
    flags = np.zeros((3, 14), bool)
    flags[:, 0], flags[0, 1] = True, True
    found = findings(dataclasses.replace(best, rules=dataclasses.replace(best.rules, reflex=flags)))
    assert list(found.reflexes.values()) == [1.0, 1 / 3] + [0.0] * 8
    words = " ".join(in_words(found, 3))
    assert f"Reflexes in every agent: {best.rules.text(0, 0)}." in words
    assert f"In some agents: {best.rules.text(0, 1)} (1 of 3)." in words


def test_packets_travel_as_the_row_says(run):
    best = run.best(0)
    row = next(row for row in run.rows if (row["instance"], row["generation"]) == (0, best.generation))
    found = findings(best, run, 0)
    assert found.delivered == row["delivered"] > 0
    assert found.carriers == pytest.approx(sum(row["contribution"]) / row["delivered"])
    shares = np.array(row["contribution"]) / sum(row["contribution"])
    assert found.carrying == pytest.approx(1 / (shares**2).sum())
    assert findings(best).carriers is None  # without its row
    thin = [{name: value for name, value in row.items() if name != "contribution"} for row in run.rows]
    assert findings(best, dataclasses.replace(run, rows=thin), 0).carriers == pytest.approx(found.carriers)


def told(reflexes: dict[str, float], acting: dict[str, float]) -> Findings:
    by_reflex = 1 - sum(acting.values())
    actions = {text.rpartition(" => ")[2]: (share, share) for text, share in acting.items()}
    return Findings(
        reflexes=reflexes,
        by_reflex=by_reflex,
        actions=actions,
        acting=acting,
        delivered=9.0,
        carriers=4.0,
        carrying=3.0,
    )


def test_shares_of_several_winners_are_means():
    several = [told({"a => x": 1.0}, {"c => x": 0.1}), told({"a => x": 0.5}, {"c => x": 0.3, "d => y": 0.1})]
    assert reflex_shares(several) == {"a => x": 0.75}
    assert acting_shares(several) == [("c => x", pytest.approx(0.2), 2), ("d => y", pytest.approx(0.05), 1)]


def test_the_page_says_where_reflexes_are_switched_off_and_what_acts_there():
    a, b = told({"a => x": 1.0, "b => y": 0.95}, {"c => x": 0.1}), told({"a => x": 1.0, "b => y": 0.2}, {"d => y": 0.6})
    worlds = {"short open": [a], "long urban": [b, b]}
    kept, off, acts, packets = in_short(worlds)
    assert kept == "Kept as a reflex by three of four agents and more, everywhere: `a => x`."
    assert off.endswith("they are left: `b => y` 20% (long urban) to 95% (short open).")
    assert "reflexes brought about 40% (long urban) to 90% (short open)" in acts
    assert packets == "A delivered packet passed through 4.0 agents."
    text = page({"informed search": worlds})
    for line in (
        "| b => y | 95% | 20% |",
        "| y | 0% (0%) | 60% (60%) |",
        "- Short open: `c => x` (10.0%; 1 of 1).",
        "- Long urban: `d => y` (60.0%; 2 of 2).",
        "| Long urban | 2 | 9.0 | 4.0 | 3.0 |",
    ):
        assert line in text.splitlines()


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
    assert "| rule | short open |" in out
    assert "| Short open | 2 | " in out
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
