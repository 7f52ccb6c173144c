"""Runs of the informed search: interrupted anywhere, continued, replayed and evaluated with reflexes and quality."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.config import InputError
from slcs2_jax.config.knowledge import Knowledge
from slcs2_jax.results.run_folder import checkpoint_limits
from slcs2_jax.running.driver import batch_key
from tests.running.crashes import assert_same_however_interrupted, results

SEARCH = {
    "name": "informed",
    "acceptance": "best",
    "parent": "tournament",
    "racing": True,
    "inherit_quality": True,
    "generations": 10,
    "starts": 2,
    "population": 4,
    "finalists": 2,
    "final_every": 5,
    "final_deployments": 2,
    "max_redeployments": 2,
    "fresh_deployments": 2,
}


def settings(run_dir, *, knowledge: dict | None = None, **search) -> slcs2.Settings:
    return slcs2.Settings(
        world=slcs2.World(distance=120.0, time_limit=60),
        swarm=slcs2.Swarm(agents=3, packets=3),
        rules=slcs2.Rules(rules=14),
        search=slcs2.Search(**(SEARCH | search)),
        knowledge=Knowledge(**({"mode": "reflex"} | (knowledge or {}))),
        compute=slcs2.Compute(devices=1, chunk=20),
        checkpoint=slcs2.Checkpoint(generations=1, seconds=0.0),
        instances=2,
        run_dir=None if run_dir is None else str(run_dir),
    )


@pytest.mark.parametrize("batch", [1, 5])
def test_a_run_that_is_interrupted_anywhere_leaves_the_same_bytes(tmp_path, batch):
    assert_same_however_interrupted(settings, tmp_path, batch)


def test_a_saved_winner_is_deployed_with_its_reflexes_and_quality(tmp_path, capfd):
    [summary] = slcs2.evolve(settings(tmp_path / "run"))
    run = slcs2.read_run(tmp_path / "run")
    for number in range(2):
        best = run.best(number)
        assert best.rules.reflex[:, :10].any()
        assert best.rules.quality is not None
        here = dataclasses.replace(run.settings, seed=best.instance_seed, instances=1, run_dir=None)
        fresh = slcs2.evaluate(here, best, deployments=2)
        assert fresh.mean == pytest.approx(summary.instances[number].fresh_mean)
        assert best.deployments >= 3  # in finals too
        assert (tmp_path / "run" / "solutions" / f"instance_{number:03d}_best.txt").read_text().count("reflex: ") > 0
    assert cli.main(["rules", str(tmp_path / "run"), "top=0"]) == 0
    assert "reflex: " in capfd.readouterr().out


def test_reflexes_decide_what_a_swarm_does(tmp_path):
    slcs2.evolve(settings(tmp_path / "run"))
    best = slcs2.read_run(tmp_path / "run").best(0)
    here = dataclasses.replace(best.settings, seed=best.instance_seed, instances=1, run_dir=None)
    none = dataclasses.replace(best.rules, reflex=np.zeros_like(best.rules.reflex))
    with_them, without = (slcs2.evaluate(here, rules, deployments=8).mean for rules in (best.rules, none))
    assert with_them != without


def test_runs_with_and_without_knowledge_are_advanced_side_by_side(tmp_path):
    alone = [slcs2.evolve(settings(None, knowledge={"mode": mode}))[0].instances for mode in ("reflex", "suggested")]
    both = slcs2.evolve(settings(None), settings(None, knowledge={"mode": "suggested"}))
    assert [one.instances for one in both] == alone
    keys = {batch_key(settings(None, knowledge={"mode": mode})) for mode in ("none", "suggested", "reflex")}
    assert len(keys) == 2


@pytest.mark.parametrize("name", ["slcs2", "random"])
def test_knowledge_goes_with_other_searches(name):
    plain = {"name": name, "acceptance": "domination", "parent": "fewest", "generations": 4}
    [summary] = slcs2.evolve(settings(None, **plain))
    assert summary.instances[0].generations == 4


def test_what_cannot_be_used_leaves_no_folder(tmp_path):
    wanted = settings(tmp_path / "run")
    wanted = dataclasses.replace(wanted, rules=slcs2.Rules(rules=9))
    with pytest.raises(InputError, match=r"accepted is a list of at most rules\.rules=9 rules; it has 10"):
        slcs2.evolve(wanted)
    assert not (tmp_path / "run").exists()


def test_the_choice_of_a_search_and_of_knowledge_on_the_command_line(capfd):
    def shown(*words: str) -> str:
        assert cli.main(["evolve", "--cfg", "job", *words]) == 0
        return capfd.readouterr().out

    informed = shown("search=informed", "generations=20")
    assert "mode: reflex" in informed
    assert "racing: true" in informed
    assert "mode: none" in shown("knowledge=none", "search=informed", "generations=20")
    assert "mode: suggested" in shown("knowledge=suggested")
    assert "mode: none" in shown()


def test_a_checkpoint_has_room_for_the_deployments_of_finals(tmp_path):
    wanted = {"fresh_deployments": 1, "batch": 5, "max_redeployments": 0, "final_deployments": 1000, "generations": 5}
    many = slcs2.Rules(rules=800)  # so many deployments of so many rules are more than a checkpoint of others can hold
    limits = [
        checkpoint_limits(dataclasses.replace(settings(tmp_path, **(wanted | change)), rules=many)).size
        for change in ({}, {"name": "slcs2"})
    ]
    assert limits[0] - limits[1] > 2 * 5 * 999 * 20 * 3 * 800


def test_distinct_rules_that_can_hold(tmp_path):
    def run(name: str, generations: int = 10) -> slcs2.Settings:
        wanted = settings(tmp_path / name, generations=generations)
        return dataclasses.replace(wanted, rules=slcs2.Rules(rules=60, distinct=True), instances=1)

    slcs2.evolve(run("once"))
    slcs2.evolve(run("further", 5))
    slcs2.evolve(run("further"))
    assert results(tmp_path / "further") == results(tmp_path / "once")
    best = slcs2.read_run(tmp_path / "once").best(0)
    fresh = best.origin_kind < 2
    for agent, ids in enumerate(best.rules.ids()):
        assert len(set(ids[fresh[agent]].tolist())) == fresh[agent].sum()
    few = tmp_path / "few.bnf"
    few.write_text("<rule> ::= packet held => collect from source | no packet held => send to si\n")
    wanted = dataclasses.replace(run("none"), rules=slcs2.Rules(rules=3, distinct=True, grammar=str(few)))
    wanted = dataclasses.replace(wanted, knowledge=Knowledge())
    with pytest.raises(InputError, match=r"rules\.distinct=true: accepted is a grammar with at least 3"):
        slcs2.evolve(wanted)
    assert not (tmp_path / "none").exists()


def test_the_list_of_knowledge_is_kept_with_the_run(tmp_path, capfd):
    rules = tmp_path / "mine.txt"
    rules.write_text("packet held => send to si\nno packet held => collect from source  # mine\n")

    def run(name: str, generations: int = 10) -> slcs2.Settings:
        return settings(tmp_path / name, knowledge={"rules": str(rules)}, generations=generations)

    slcs2.evolve(run("once"))
    slcs2.evolve(run("further", 5))
    assert (tmp_path / "further" / "knowledge.txt").read_text() == rules.read_text()
    rules.write_text("packet held => send to si\n")
    with pytest.raises(InputError, match=r"knowledge\.rules=.*mine\.txt: is not what it was when the run"):
        slcs2.evolve(run("further"))
    rules.unlink()
    slcs2.evolve(run("further"))
    assert results(tmp_path / "further") == results(tmp_path / "once")
    assert cli.main(["repeat", str(tmp_path / "once")]) == 0
    assert "it came to the same" in capfd.readouterr().out
    with (tmp_path / "once" / "knowledge.txt").open("a") as file:
        file.write("# another line\n")
    assert cli.main(["repeat", str(tmp_path / "once")]) == 2
    assert "knowledge.txt: not the list of knowledge that the run was started with" in capfd.readouterr().err


def test_the_search_that_evolve_is_given_brings_its_parts(tmp_path):
    plain = dataclasses.replace(settings(tmp_path / "run"), search=slcs2.Search(generations=20, fresh_deployments=1))
    plain = dataclasses.replace(plain, knowledge=Knowledge(), instances=1)
    slcs2.evolve(plain, search="informed")
    made = slcs2.read_run(tmp_path / "run").settings
    assert (made.search.name, made.search.racing, made.knowledge.mode) == ("informed", True, "reflex")
    without = dataclasses.replace(made, knowledge=Knowledge(), run_dir=str(tmp_path / "without"))
    slcs2.evolve(without, search="informed")  # it is that already: nothing is brought back
    assert slcs2.read_run(tmp_path / "without").settings.knowledge.mode == "none"
