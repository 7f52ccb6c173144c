"""Many policies in many scenarios at once come to what each comes to alone, from programs that are compiled once."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from slcs2_jax.config import Compute, InputError, Rules, Settings, Swarm, World
from slcs2_jax.grammar import load_grammar, random_rule_sets
from slcs2_jax.policy.bound import bind
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.policy.network import Network
from slcs2_jax.results import Quiet
from slcs2_jax.running import driver
from slcs2_jax.running.batches import Rollouts
from slcs2_jax.running.evaluator import Evaluator
from slcs2_jax.search import Solution
from slcs2_jax.world.scenario import make_scenario

AGENTS, RULES = 3, 10
SIZES = itertools.count()
SETTINGS = Settings(
    world=World(distance=190.0, time_limit=200),
    swarm=Swarm(agents=AGENTS, packets=4),
    rules=Rules(rules=RULES),
    compute=Compute(devices=1, cache=False, chunk=50),
    instances=2,
    seed=5,
)


@pytest.fixture(scope="module")
def policies() -> list:
    rng = np.random.default_rng(2)
    return [random_rule_sets(load_grammar("main"), AGENTS, RULES, rng) for _ in range(3)]


@pytest.fixture(scope="module")
def evaluator() -> Evaluator:
    return Evaluator(SETTINGS, measures={"pace": lambda done, scenario: done.delivered / scenario.time_limit})


@pytest.fixture(scope="module")
def result(evaluator, policies):
    return evaluator(policies, [3, 4], deployments=2)


def test_shapes_and_figures(result):
    assert result.fitness.shape == result.delivered.shape == result.steps.shape == (3, 2, 2)
    assert result.contribution.shape == (3, 2, 2, AGENTS)
    np.testing.assert_array_equal(result.fitness, result.delivered / 4 - result.steps / 200)
    np.testing.assert_array_equal(result.measures["pace"], result.delivered / 200)
    np.testing.assert_array_equal(result.mean, result.fitness.mean(axis=(1, 2)))
    assert result.deployments[2][1][0].figures.shape == (AGENTS, RULES)
    assert len(np.unique(result.fitness)) > 1
    assert result.usage.useful_steps == result.steps.sum()


def test_each_alone_comes_to_the_same(evaluator, policies, result):
    alone = evaluator([policies[1]], [make_scenario(SETTINGS, 4)], deployments=1)
    one, other = alone.deployments[0][0][0], result.deployments[1][1][0]
    assert (one.fitness, one.delivered, one.steps) == (other.fitness, other.delivered, other.steps)
    for name, array in one.figures.arrays().items():
        np.testing.assert_array_equal(array, other.figures.arrays()[name])


def test_programs_are_made_once(policies, monkeypatch):
    made = []
    make = Rollouts._made
    monkeypatch.setattr(Rollouts, "_made", lambda self, *arguments: made.append(arguments) or make(self, *arguments))
    evaluator = Evaluator(SETTINGS)
    first = evaluator(policies[:1], [0])
    assert first.usage.compile_seconds > 0
    again = evaluator(policies, [1, 2], deployments=3)
    assert len(made) == 1
    assert again.usage.compile_seconds == 0
    fence = np.array([[60.0, -300.0, 300.0]], np.float32)
    fenced = dataclasses.replace(make_scenario(SETTINGS, 0), vertical=fence)
    evaluator(policies, [fenced])
    assert len(made) == 2, "walls need room"
    np.testing.assert_array_equal(evaluator(policies[:1], [0]).fitness, first.fitness)


def test_policies_of_all_kinds_together(evaluator, policies):
    grammar = load_grammar("main")
    network = Network.over(grammar, _apply)
    bound = bind(network, {"w": np.ones((1, len(grammar.actions) + 1), np.float32)})
    designed = load_decision_list("designed")
    solution = Solution.made(policies[0], generation=0)
    found = evaluator([designed, solution, bound, policies[0]], [3])
    np.testing.assert_array_equal(found.fitness[1], found.fitness[3])
    assert found.deployments[0][0][0].figures.shape == (AGENTS, len(designed.rules))
    assert found.deployments[2][0][0].figures is None
    assert np.isfinite(found.fitness).all()


def _apply(parameters, carry, features):
    return carry, features[:1] @ parameters["w"]


def test_scenarios_are_those_of_the_settings_by_default(evaluator, policies):
    default, named = evaluator(policies[:1]), evaluator(policies[:1], range(5, 7))
    np.testing.assert_array_equal(default.fitness, named.fitness)


def test_evaluate_is_the_same_thing(evaluator, policies):
    summary = driver.evaluate(SETTINGS, policies[0], deployments=2)
    found = evaluator(policies[:1], deployments=2)
    assert [one.fitness for one in summary.scenarios] == pytest.approx(found.fitness[0].mean(axis=-1).tolist())
    assert [one.seed for one in summary.scenarios] == [5, 6]


def test_runs_in_many_worlds_are_each_one_alone():
    def small(environment: str, seed: int, instances: int) -> Settings:
        world = dataclasses.replace(World.preset(environment), distance=190.0, time_limit=200)
        return dataclasses.replace(SETTINGS, world=world, seed=seed, instances=instances)

    decisions = load_decision_list("designed")
    runs = [small("open", 3, 2), small("urban", 0, 1), small("open", 7, 1)]
    found = driver.deploy_in_runs(runs, decisions, deployments=2)
    assert [[len(instance) for instance in instances] for instances in found] == [[2, 2], [2], [2]]
    for settings, instances in zip(runs, found, strict=True):
        alone = driver.evaluate(settings, decisions, deployments=2)
        means = [sum(one.fitness for one in instance) / 2 for instance in instances]
        assert means == pytest.approx([scenario.fitness for scenario in alone.scenarios])


class Stop(BaseException):
    """Ctrl-C, at a time of our choosing."""


def test_after_an_interruption_it_works_as_before(evaluator, policies, result):
    class Report(Quiet):
        def generation(self, **values):
            raise Stop

    with pytest.raises(Stop):
        evaluator(policies, [3], report=Report())
    np.testing.assert_array_equal(evaluator(policies, [3, 4], deployments=2).fitness, result.fitness)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"policies": []}, "policies=list: accepted is a sequence of at least one policy"),
        ({"policies": ["designed"]}, r"policies\[0\]=str: accepted is a RuleSets"),
        ({"scenarios": []}, "scenarios=list: accepted is a sequence of at least one scenario or seed"),
        ({"scenarios": [-1]}, "seed=-1: accepted is a whole number"),
        ({"deployments": 0}, "deployments=0: accepted is a whole number from 1"),
    ],
)
def test_bad_arguments_are_refused(evaluator, policies, values, says):
    given = {"policies": policies, "scenarios": [0], "deployments": 1} | values
    with pytest.raises(InputError, match=says):
        evaluator(given["policies"], given["scenarios"], deployments=given["deployments"])


def test_sizes_and_grammars_that_do_not_fit_are_refused(evaluator, policies):
    rng = np.random.default_rng(0)
    both = random_rule_sets(load_grammar("both"), AGENTS, RULES, rng)
    with pytest.raises(InputError, match=r"policies\[1\]: \[3, 4\] agents and rules; accepted are \[3, 10\]"):
        evaluator([policies[0], random_rule_sets(load_grammar("main"), AGENTS, 4, rng)], [0])
    with pytest.raises(InputError, match=r"cannot be said in grammar=main"):
        evaluator([both], [0])


@pytest.mark.parametrize(
    ("measure", "says"),
    [
        (lambda done, scenario: float("nan"), r"measures\[mine\]: returned something that is no finite number"),
        (lambda done, scenario: "fast", r"measures\[mine\]: returned something that is no finite number"),
        (
            lambda done, scenario: np.zeros(next(SIZES)),
            r"measures\[mine\]: returned shapes .*; accepted is one shape",
        ),
    ],
)
def test_measures_that_are_no_numbers_are_named(policies, measure, says):
    evaluator = Evaluator(SETTINGS, measures={"mine": measure})
    with pytest.raises(InputError, match=says):
        evaluator(policies, [3], deployments=4)
    with pytest.raises(InputError, match=r"measures\[mine\]=int: accepted is a function"):
        Evaluator(SETTINGS, measures={"mine": 3})
