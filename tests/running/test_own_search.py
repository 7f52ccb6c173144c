"""A search, and parts of one, that a user brings: evolved, saved, continued and repeated as any other."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax.config.registry import KINDS
from slcs2_jax.looking.solutions import members_of
from slcs2_jax.results.arm import arm_of, arm_title
from slcs2_jax.running import driver
from slcs2_jax.search import BaseSearch, Member, Solution, Verdict
from tests.running.crashes import Crash, Crasher, crash_and_go_on, results


class Climber(BaseSearch):
    """Changes a tenth of the best solution's rules; all of a swarm share them if they must."""

    def propose(self, generation: int) -> Solution:
        fresh = self.problem.random_solution(self.supply, generation)
        if not self.members:
            return fresh
        kept = self.best.solution
        shape = (1, self.problem.rules) if self.settings.homogeneous else self.problem.shape
        change = np.broadcast_to(self.rng.random(shape) < 0.1, self.problem.shape)
        pairs = ((fresh.arrays()[name], array) for name, array in kept.arrays().items())
        names = kept.arrays()
        mixed = {
            name: np.where(change[..., None] if new.ndim == 3 else change, new, old)
            for name, (new, old) in zip(names, pairs, strict=True)
        }
        return Solution.of(mixed | {"generation": generation, "parent": kept.generation}, kept.rules.vocabulary)

    def consider(self, newcomer: Member) -> Verdict:
        better = not self.members or newcomer.fitness > self.best.fitness
        return Verdict(accepted=better, size=1)


def settings(run_dir, **search) -> slcs2.Settings:
    values = {"generations": 6, "fresh_deployments": 2} | search
    return slcs2.Settings(
        world=slcs2.World(distance=120.0, time_limit=60),
        swarm=slcs2.Swarm(agents=3, packets=3),
        rules=slcs2.Rules(rules=6),
        search=slcs2.Search(**values),
        compute=slcs2.Compute(devices=1, chunk=20),
        checkpoint=slcs2.Checkpoint(generations=1, seconds=None),
        instances=2,
        run_dir=str(run_dir),
    )


@pytest.fixture
def climber():
    slcs2.register("search", "climber")(Climber)
    yield "climber"
    KINDS["search"].forget("climber")


def rows(folder) -> list[dict]:
    return list(slcs2.read_run(folder).rows)


@pytest.mark.parametrize("batch", [1, 3])
def test_it_is_saved_gone_on_with_and_repeated(climber, tmp_path, batch):
    wanted = settings(tmp_path / "once", batch=batch)
    [summary] = slcs2.evolve(wanted, search=climber)
    # the class is known by its registered name
    crash_and_go_on(settings(tmp_path / "again", batch=batch), (4, 4, 4), search=Climber)
    assert results(tmp_path / "again") == results(tmp_path / "once")
    run = slcs2.read_run(tmp_path / "once")
    assert run.settings.search.name == climber
    assert [row["generation"] for row in run.rows if row["instance"] == 0] == list(range(6))
    assert {row["size"] for row in run.rows} == {1}
    best = run.best(0)
    assert best.fitness == summary.instances[0].best_fitness == max(row["fitness"] for row in run.rows[::2])
    assert len(run.members(0)) == 1
    fresh = slcs2.evaluate(dataclasses.replace(run.settings, instances=1, run_dir=None), best, deployments=2)
    assert fresh.mean == pytest.approx(summary.instances[0].fresh_mean)


def test_a_run_under_way_shows_its_members(climber, tmp_path):
    with pytest.raises(Crash):
        slcs2.evolve(settings(tmp_path / "run"), search=climber, report=Crasher(14))
    run = slcs2.read_run(tmp_path / "run")
    assert run.summary is None
    [member] = members_of(run, 0)
    assert member.fitness == max(row["fitness"] for row in run.rows if row["instance"] == 0)


def test_repeat_makes_it_again_and_the_command_line_goes_on(climber, tmp_path, capfd):
    from slcs2_jax import cli

    slcs2.evolve(settings(tmp_path / "run", generations=2), search=climber)
    assert cli.main(["repeat", str(tmp_path / "run")]) == 0
    assert cli.main(["resume", str(tmp_path / "run"), "generations=6"]) == 0
    slcs2.evolve(settings(tmp_path / "once"), search=climber)
    assert results(tmp_path / "run") == results(tmp_path / "once")


def test_reports_name_the_algorithm_that_ran(climber, tmp_path):
    named = {name: arm_of(settings(tmp_path, name=name)) for name in ("slcs2", "random", climber)}
    assert [arm_title(arm) for arm in named.values()] == ["SLCS2", "random search", "climber"]
    assert arm_title(arm_of(settings(tmp_path, homogeneous=True))) == "homogeneous"
    assert arm_title(arm_of(settings(tmp_path, name="random", homogeneous=True))) == "random homogeneous"


def test_a_class_that_was_not_registered_is_under_its_own_name(tmp_path):
    class Steady(Climber):
        """Nothing else."""

    try:
        slcs2.evolve(settings(tmp_path / "run", generations=1), search=Steady)
        assert slcs2.read_run(tmp_path / "run").settings.search.name == "Steady"
    finally:
        KINDS["search"].forget("Steady")
    with pytest.raises(slcs2.InputError, match="search=int: accepted is a name, or a class or function"):
        slcs2.evolve(settings(tmp_path / "other"), search=3)


def test_another_search_is_not_mixed_in(climber, tmp_path):
    slcs2.evolve(settings(tmp_path / "run"), search=climber)
    with pytest.raises(slcs2.InputError, match=r"search\.name=slcs2: .* already holds a run with search\.name=climber"):
        slcs2.evolve(settings(tmp_path / "run"))


def test_random_search_spends_the_episodes_it_is_given(tmp_path):
    [evolved] = slcs2.evolve(settings(tmp_path / "evolved"))
    spent = evolved.instances[0].evaluations
    [random] = slcs2.evolve(settings(tmp_path / "random", generations=1000, episodes=spent), search="random")
    for instance in random.instances:
        assert spent <= instance.evaluations <= spent + 5
    first = [rows(tmp_path / name)[0] for name in ("evolved", "random")]
    assert first[0]["fitness"] == first[1]["fitness"], "both begin with the same random solution"


@pytest.mark.parametrize("name", ["slcs2", "random", "climber"])
def test_a_homogeneous_swarm_has_one_rule_set(climber, tmp_path, name):
    slcs2.evolve(settings(tmp_path / "run", homogeneous=True), search=name)
    run = slcs2.read_run(tmp_path / "run")
    for instance in range(2):
        best = run.best(instance)
        assert (best.rules.mask == best.rules.mask[:1]).all()
        assert (best.rules.action == best.rules.action[:1]).all()
        assert not (best.usage == best.usage[:1]).all(), "each agent learns for itself"
    assert {row["copied"] for row in run.rows} == {0}
    assert slcs2.replay(best, deployment=1).contribution.shape == (3,)


def test_parts_of_the_search_are_replaced_by_name(tmp_path):
    class Newest:
        """The newest member, always."""

        def __init__(self, problem):
            self.problem = problem

        def __call__(self, members, rng):
            return max(members, key=lambda member: member.generation)

    class Shuffle:
        """The parent's rule-sets, handed round at random."""

        def __init__(self, problem):
            self.problem = problem

        def __call__(self, parent, evaluation, *, explorations, generation, members, supply, rng):
            order = rng.permutation(self.problem.agents)
            values = {name: array[order] for name, array in parent.arrays().items()}
            return Solution.of(parent.values() | values | {"generation": generation, "parent": parent.generation})

    class Everything:
        """Keeps all."""

        def __init__(self, problem):
            self.held = []

        def consider(self, newcomer):
            self.held.append(newcomer)
            return Verdict(size=len(self.held))

        def members(self):
            return list(self.held)

        def state(self):
            return {}

        def restore(self, members, state):
            self.held = members

    parts = {"parent": Newest, "variation": Shuffle, "acceptance": Everything}
    for kind, part in parts.items():
        slcs2.register(kind, "mine")(part)
    try:
        mine = dict.fromkeys(parts, "mine")
        with pytest.raises(Crash):
            driver.evolve([settings(tmp_path / "run", **mine)], report=Crasher(8))
        driver.evolve([settings(tmp_path / "run", **mine)])
        driver.evolve([settings(tmp_path / "once", **mine)])
    finally:
        for kind in parts:
            KINDS[kind].forget("mine")
    assert results(tmp_path / "run") == results(tmp_path / "once")
    made = [row for row in rows(tmp_path / "run") if row["instance"] == 0]
    assert [row["parent"] for row in made] == [-1, 0, 1, 2, 3, 4]
    assert [row["size"] for row in made] == [1, 2, 3, 4, 5, 6]
    assert {row["fresh"] for row in made[1:]} == {0}
