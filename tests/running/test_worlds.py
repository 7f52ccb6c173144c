"""Runs of one search through many worlds: interrupted anywhere, replayed, deployed afresh in all of them."""

from __future__ import annotations

import dataclasses

import pytest

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.config.worlds import worlds_of
from slcs2_jax.looking.solutions import replay
from tests.running.crashes import assert_same_however_interrupted
from tests.running.test_informed import settings as single

WORLDS = ("open/0..2", "urban/5..6")


def settings(run_dir, **search) -> slcs2.Settings:
    base = single(run_dir, **search)
    world = dataclasses.replace(base.world, distance=150.0)
    return dataclasses.replace(base, world=world, worlds=WORLDS)


@pytest.mark.parametrize("batch", [1, 5])
def test_a_run_that_is_interrupted_anywhere_leaves_the_same_bytes(tmp_path, batch):
    assert_same_however_interrupted(settings, tmp_path, batch)


def test_the_winner_is_deployed_afresh_in_all_worlds(tmp_path):
    [summary] = slcs2.evolve(settings(tmp_path / "run"))
    run = slcs2.read_run(tmp_path / "run")
    for number, one in enumerate(summary.instances):
        best = run.best(number)
        assert best.deployments % 5 == 0
        shown = [replay(best, deployment=index) for index in range(5)]  # 2 fresh deployments are too few for 5 worlds
        seeds = [recording.scenario.seed for recording in shown]
        assert seeds == [seed for _, _, seed in worlds_of(run.settings)] == [0, 5, 1, 6, 2]
        assert sum(recording.fitness for recording in shown) / 5 == pytest.approx(one.fresh_mean)
    rows = [row for row in run.rows if row["instance"] == 0]
    assert {row["deployments"] for row in rows} <= {2, 3, 4, 5}
    assert any(row["deployments"] == 5 for row in rows)


def test_other_searches_go_through_each_world_once(tmp_path):
    plain = {"name": "slcs2", "acceptance": "domination", "parent": "fewest", "racing": False, "generations": 3}
    slcs2.evolve(settings(tmp_path / "run", **plain))
    assert {row["deployments"] for row in slcs2.read_run(tmp_path / "run").rows} == {5}


def test_a_winner_keeps_its_quality_or_forgets_it(tmp_path, capfd):
    wanted = settings(tmp_path / "run")
    slcs2.evolve(dataclasses.replace(wanted, knowledge=slcs2.Knowledge()))
    members = slcs2.read_run(tmp_path / "run").members(0)
    number = next(place for place, member in enumerate(members) if member.rules.quality.any())
    assert members[number].forgetful().rules.quality is None
    path = tmp_path / "run" / "solutions" / f"instance_000_member_{number:03d}.npz"
    printed = []
    for quality in ("kept", "forgotten"):
        line = ["evaluate", f"solution={path}", "instances=2", "deployments=4", f"quality={quality}"]
        line += ["world.distance=400", "world.time_limit=400"]
        assert cli.main([*line, "compute.devices=1"]) == 0
        printed.append(capfd.readouterr().out.splitlines()[0:4])
    assert printed[0] != printed[1]
    assert cli.main(["evaluate", f"solution={path}", "quality=lost"]) == 2
    assert "quality=lost: accepted is one of kept, forgotten" in capfd.readouterr().err
    assert cli.main(["evaluate", f"solution={path}", "worlds=[open/short/0]"]) == 2
    assert "worlds: not here" in capfd.readouterr().err
