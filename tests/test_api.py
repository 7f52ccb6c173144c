"""The Python interface: names that cost nothing until used, and deploy, evolve, evaluate in small worlds."""

from __future__ import annotations

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

import slcs2_jax as slcs2

AGENTS, RULES = 3, 10


@pytest.fixture(scope="module")
def settings() -> slcs2.Settings:
    return slcs2.Settings(
        world=slcs2.World(distance=190.0, time_limit=200),
        swarm=slcs2.Swarm(agents=AGENTS, packets=4),
        rules=slcs2.Rules(rules=RULES),
        search=slcs2.Search(generations=2, fresh_deployments=3),
        compute=slcs2.Compute(devices=1, cache=False, chunk=50),
        instances=1,
    )


@pytest.fixture(scope="module")
def rules() -> slcs2.RuleSets:
    return slcs2.random_rule_sets(slcs2.load_grammar("main"), AGENTS, RULES, np.random.default_rng(4))


def python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_importing_starts_neither_jax_nor_hydra():
    code = "import slcs2_jax, sys; print([m for m in ('jax', 'numpy', 'hydra', 'omegaconf') if m in sys.modules])"
    assert python(code) == "[]\n"


def test_only_what_computes_starts_jax():
    computing = {"animate", "deploy", "evaluate", "evolve", "replay", "Evaluator", "Env", "AutoReset", "make"}
    computing |= {"Network", "Policy"}
    computing |= {"BoundPolicy", "bind", "bind_list", "bind_rules", "collect", "move", "send", "Delivery", "Score"}
    quick = sorted(set(slcs2.__all__) - computing)
    code = f"import slcs2_jax, sys; [getattr(slcs2_jax, name) for name in {quick}]; print('jax' in sys.modules)"
    assert python(code) == "False\n"


def test_every_name_is_there_and_documented():
    for name in slcs2.__all__:
        value = getattr(slcs2, name)
        assert name in dir(slcs2)
        assert name == "__version__" or value.__doc__, name


def test_a_name_is_the_thing_itself_and_not_a_copy():
    from slcs2_jax import api, config, grammar, results

    assert slcs2.Settings is config.Settings
    assert slcs2.RuleSets is grammar.RuleSets
    assert slcs2.read_run is results.read_run
    assert slcs2.evolve is api.evolve


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'evolution_strategy'"):
        slcs2.evolution_strategy  # noqa: B018


def test_deployments_differ_from_each_other_and_not_from_call_to_call(settings, rules):
    scenario = slcs2.make_scenario(settings, 3)
    episodes = slcs2.deploy(settings, scenario, rules, deployments=4)
    assert len({episode.figures.quality.tobytes() for episode in episodes}) == 4
    for episode in episodes:
        assert episode.fitness == episode.delivered / 4 - episode.steps / 200
        assert (episode.figures.shape, episode.contribution.shape) == ((AGENTS, RULES), (AGENTS,))
    again = slcs2.deploy(settings, scenario, rules, deployments=2)
    for one, other in zip(again, episodes, strict=False):
        assert (one.fitness, one.delivered, one.steps) == (other.fitness, other.delivered, other.steps)
        np.testing.assert_array_equal(one.contribution, other.contribution)
        for name, array in one.figures.arrays().items():
            np.testing.assert_array_equal(array, other.figures.arrays()[name])


def test_a_scenario_made_by_hand(settings, rules):
    scenario = slcs2.make_scenario(settings, 0)
    fence = np.array([[60.0, -300.0, 300.0]], np.float32)
    fenced = dataclasses.replace(scenario, vertical=fence, sink=np.array([400.0, 0.0], np.float32))
    [episode] = slcs2.deploy(settings, fenced, rules)
    assert episode.delivered == 0, "the sink is beyond the fence and out of reach"


def test_deploy_refuses_what_it_would_compute_wrongly(settings, rules):
    scenario = slcs2.make_scenario(settings, 0)
    more = dataclasses.replace(settings, swarm=slcs2.Swarm(agents=AGENTS + 1))
    both = slcs2.random_rule_sets(slcs2.load_grammar("both"), AGENTS, RULES, np.random.default_rng(0))
    thick = dataclasses.replace(scenario, wall_thickness=2.0)
    starts = dataclasses.replace(scenario, start=scenario.start[:2])
    for arguments, part in (
        (
            (more, dataclasses.replace(scenario, start=np.zeros((AGENTS + 1, 2), np.float32)), rules),
            r"policy: \[3, 10\] agents and rules; accepted are \[4, 10\]",
        ),
        ((settings, starts, rules), r"scenario\.start=float32 \[2, 2\]: accepted is a float32 array \[3, 2\]"),
        ((settings, thick, rules), r"scenario\.wall_thickness=2.*: accepted is 1 m, as world.wall_thickness says"),
        ((settings, scenario, both), "rules: '.*=>.*' cannot be said in grammar=main"),
    ):
        with pytest.raises(slcs2.InputError, match=part):
            slcs2.deploy(*arguments)
    for count in (0, 2.5, True, "3", None, float("nan")):
        with pytest.raises(slcs2.InputError, match=r"deployments=.*: accepted is a whole number from 1 to"):
            slcs2.deploy(settings, scenario, rules, deployments=count)


def test_what_is_no_argument_at_all_is_refused_in_the_same_words(settings, rules):
    scenario = slcs2.make_scenario(settings, 0)
    grammar, rng = slcs2.load_grammar("main"), np.random.default_rng(0)
    for call, part in (
        (lambda: slcs2.deploy({}, scenario, rules), "settings=dict: accepted is a Settings"),
        (lambda: slcs2.deploy(settings, None, rules), "scenario=NoneType: accepted is a Scenario"),
        (
            lambda: slcs2.deploy(settings, scenario, rules.mask),
            r"policy=ndarray: accepted is a RuleSets, Solution, SavedSolution, DecisionList or BoundPolicy",
        ),
        (lambda: slcs2.evolve("open"), "settings=str: accepted is a Settings"),
        (
            lambda: slcs2.evaluate(settings, "best.npz"),
            r"policy=str: accepted is a RuleSets, Solution, SavedSolution, DecisionList or BoundPolicy",
        ),
        (lambda: slcs2.load_solution(3), "solution=3: accepted is the path of a file"),
        (lambda: slcs2.read_run(None), "run=null: accepted is the path of a file or folder"),
        (lambda: slcs2.make_scenario(settings, -1), "seed=-1: accepted is a whole number from 0"),
        (lambda: slcs2.make_scenario("urban", 0), "settings=str: accepted is a Settings"),
        (lambda: slcs2.random_rule_sets(grammar, 0, 5, rng), "agents=0: accepted is a whole number from 1 to 64"),
        (lambda: slcs2.random_rule_sets(grammar, 2, 5.0, rng), "rules=5.0: accepted is a whole number from 1"),
        (lambda: slcs2.random_rule_sets("main", 2, 5, rng), "grammar=str: accepted is a Grammar"),
        (lambda: slcs2.random_rule_sets(grammar, 2, 5, 7), "rng=int: accepted is a Generator"),
        (lambda: slcs2.World.preset("forest"), "environment=forest: accepted is one of open"),
        (lambda: slcs2.World.preset(["open"]), "environment=.*: accepted is one of open"),
        (lambda: slcs2.Swarm(agents=float("nan")), "swarm.agents=nan: accepted is a whole number"),
    ):
        with pytest.raises(slcs2.InputError, match=part):
            call()


def test_evolve_then_evaluate(settings, tmp_path):
    settings = dataclasses.replace(settings, run_dir=str(tmp_path / "run"))
    [run] = slcs2.evolve(settings)
    best = slcs2.read_run(run.run_dir).best(0)
    [instance] = run.instances
    assert best.fitness == instance.best_fitness
    assert slcs2.evaluate(settings, best, deployments=3).mean == instance.fresh_mean
    episodes = slcs2.deploy(settings, slcs2.make_scenario(settings, 0), best.rules, deployments=3)
    assert np.mean([episode.fitness for episode in episodes]) == pytest.approx(instance.fresh_mean, abs=1e-12)


def test_an_instance_that_does_not_exist_is_refused(settings, tmp_path):
    slcs2.evolve(dataclasses.replace(settings, run_dir=str(tmp_path / "run")))
    run = slcs2.read_run(tmp_path / "run")
    for instance in (1, -1, 0.0):
        for read in (run.best, run.members):
            with pytest.raises(slcs2.InputError, match=r"instance=.*: accepted is a whole number from 0 to 0"):
                read(instance)


def test_evolve_needs_settings():
    with pytest.raises(slcs2.InputError, match="settings: none given"):
        slcs2.evolve()
