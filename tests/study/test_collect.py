"""Collecting results: every instance of every run below a folder, told apart by the settings in which they differ."""

import json

import pytest

from slcs2_jax.config import InputError, Radio, Rules, Search, Settings
from slcs2_jax.results import RunFolder
from slcs2_jax.results.arm import Cell, arm_of
from slcs2_jax.study.collect import collect


def test_an_ended_and_an_unfinished_run(make):
    make.evolved("slcs2", "open_short", 3, [0.1, 0.2, 0.5], fresh=0.4)
    make.evolved("ailta", "urban_long", 4, [-1.0, -0.5], planned=7)
    unfinished, ended = collect(make.root)
    assert (ended.arm, ended.cell, ended.seed, ended.planned) == ("slcs2", Cell("open", "short"), 3, 3)
    assert [ended.best(count) for count in (0, 1, 2, 3, 4)] == [None, 0.1, 0.2, 0.5, None]
    assert (ended.fresh_after(3), ended.fresh_after(2)) == (0.4, None)
    assert (ended.evaluations, ended.env_steps) == (10, 1000)
    assert (unfinished.arm, unfinished.planned, list(unfinished.curve)) == ("ailta", 7, [-1.0, -0.5])
    assert (unfinished.best(2), unfinished.fresh_after(2)) == (-0.5, None)


def test_a_designed_behaviours_result_is_its_mean(make):
    make.designed("urban_short", 0, [-1.0, 0.5, 0.2])
    [one] = collect(make.root)
    assert (one.arm, one.evolves, list(one.deployments)) == ("designed", False, [-1.0, 0.5, 0.2])
    assert one.best(500) == one.fresh_after(7) == pytest.approx(-0.1)


def spent(generation):
    return {"deployments": 1 + generation, "steps": 10.0 * (1 + generation)}


def test_the_instances_of_one_run(tmp_path):
    folder = RunFolder.create(Settings(seed=5, instances=2, run_dir=str(tmp_path)), device="cpu", kind="evolve")
    rows = [(0, 0, 0.1), (1, 0, 0.3), (1, 1, 0.4)]
    folder.append({"instance": i, "generation": g, "best": best, **spent(g)} for i, g, best in rows)
    found = collect(tmp_path)
    assert [(one.seed, list(one.curve)) for one in found] == [(5, [0.1]), (6, [0.3, 0.4])]
    assert [(list(one.episodes), list(one.steps)) for one in found] == [([1], [10]), ([1, 3], [10, 50])]


def test_rows_in_any_order_and_up_to_the_first_gap(tmp_path):
    folder = RunFolder.create(Settings(instances=1, run_dir=str(tmp_path)), device="cpu", kind="evolve")
    folder.append({"instance": 0, "generation": g, "best": g / 10, **spent(g)} for g in (2, 0, 1, 4))
    assert list(collect(tmp_path)[0].curve) == [0.0, 0.1, 0.2]


def test_the_evaluation_of_a_saved_solution_is_no_result(make):
    make.evolved("slcs2", "open_short", 0, [0.1])
    folder = RunFolder.create(
        Settings(run_dir=str(make.root / "evaluation")), device="cpu", record={"solution": "some.npz"}
    )
    folder.write_summary({"fitness_mean": 0.5, "scenarios": []})
    assert len(collect(make.root)) == 1


@pytest.mark.parametrize("made", [True, False])
def test_a_folder_without_runs(tmp_path, made):
    folder = tmp_path / "runs"
    if made:
        folder.mkdir()
        (folder / "config.txt").write_text("radio: {}")
    with pytest.raises(InputError, match=r"runs: (holds no run|no such folder); accepted is a folder with runs"):
        collect(folder)


def test_runs_of_which_none_has_begun(make):
    make.evolved("slcs2", "open_short", 0, [], planned=5)
    with pytest.raises(InputError, match=r"runs: no run in it has finished a generation"):
        collect(make.root)


def test_runs_that_differ_in_a_setting_are_told_apart(make):
    make.evolved("slcs2", "open_short", 0, [0.1])
    make.evolved("ailta", "open_long", 0, [0.1], radio={"noise_dbm": -90.0})
    changed, plain = collect(make.root)
    assert (plain.arm, plain.point) == ("slcs2", ())
    assert (changed.arm, changed.algorithm) == ("ailta at radio.noise_dbm=-90.0", "ailta")
    assert changed.point == (("radio.noise_dbm", -90.0),)


def test_how_a_machine_was_used_may_differ(make):
    make.evolved("slcs2", "open_short", 0, [0.1], compute={"devices": 1})
    make.evolved("slcs2", "open_short", 1, [0.1, 0.2], compute={"devices": 2, "slots": 32})
    assert len(collect(make.root)) == 2


def test_an_instance_that_is_there_twice(make, tmp_path):
    make.evolved("slcs2", "open_short", 0, [0.1])
    other = type(make)(make.root / "again")
    other.evolved("slcs2", "open_short", 0, [0.1])
    with pytest.raises(InputError, match=r"seed=0: slcs2 in the short open world is both in .*again.* and in "):
        collect(make.root)


def test_a_damaged_run(make):
    path = make.evolved("slcs2", "open_short", 0, [0.1], fresh=0.1)
    (path / "summary.json").write_text(json.dumps({"generations": 1}))
    with pytest.raises(InputError, match=r"summary\.json"):
        collect(make.root)


def test_a_row_without_its_figure(make):
    path = make.evolved("slcs2", "open_short", 0, [0.1])
    RunFolder(path, None).append([{"instance": 0, "generation": 1}])  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"seed_000: rows or summary without a figure"):
        collect(make.root)


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        (Settings(), "slcs2"),
        (Settings(search=Search(acceptance="ailta")), "ailta"),
        (Settings(search=Search(exchange=False)), "no_exchange"),
        (Settings(rules=Rules(grammar="power")), "power"),
        (Settings(rules=Rules(grammar="some/mine.bnf"), search=Search(exchange=False)), "no_exchange_mine"),
        (Settings(radio=Radio(noise_dbm=-90.0)), "slcs2"),
    ],
)
def test_the_name_of_an_arm(settings, name):
    assert arm_of(settings) == name
