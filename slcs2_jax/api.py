"""The main jobs from Python: deploy a solution, evolve one, evaluate a saved one. Importing this starts JAX.

Each sets JAX up as the command line does (`runtime.configure`), where JAX does not run yet.
"""

from __future__ import annotations

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.grammar import Grammar, RuleSets, make_rule
from slcs2_jax.results import EvaluationSummary, Report, RunSummary, SavedSolution
from slcs2_jax.running import driver
from slcs2_jax.running.batches import make_batches
from slcs2_jax.running.instance import Measurement, Site
from slcs2_jax.running.schedule import play
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.swarm.task import task_of
from slcs2_jax.world.scenario import Scenario, check_scenario

MOST_DEPLOYMENTS = 10**6


def deploy(settings: Settings, scenario: Scenario, rules: RuleSets, *, deployments: int = 1) -> list[Deployment]:
    """Episodes of a solution in one scenario, each with randomness of its own (spec section 7).

    Args:
        settings: radio, swarm, learning and rules; of the world the thickness of walls alone is looked at.
        scenario: where, from `make_scenario` or made by hand.
        rules: mask uint32[n, R, 4] and action uint8[n, R].
        deployments: how many episodes; episode i is the same in every call.

    Returns:
        For each its fitness, packets delivered, steps, and per agent and rule what was learnt.

    Raises:
        InputError: fewer than one deployment, or a scenario or rules that the settings do not fit.
    """
    for name, value, kind in (
        ("settings", settings, Settings),
        ("scenario", scenario, Scenario),
        ("rules", rules, RuleSets),
    ):
        of_kind(name, value, kind)
    deployments = whole("deployments", deployments, 1, MOST_DEPLOYMENTS)
    grammar = Grammar.of(settings)
    _check(settings, scenario, rules, grammar)
    runtime.configure(settings.compute)
    task = Measurement(
        Site(scenario, grammar.channels_used, settings.swarm.packets, task_of(settings)), rules, deployments
    )
    play(make_batches(settings, [grammar], [task]), lambda: None)
    return task.deployments


def _check(settings: Settings, scenario: Scenario, rules: RuleSets, grammar: Grammar) -> None:
    """Refuse what would otherwise be computed wrongly without a word."""
    size = (settings.swarm.agents, settings.rules.rules)
    if rules.action.shape != size:
        raise InputError(f"rules: {list(rules.action.shape)} agents and rules; accepted are {list(size)}")
    check_scenario(scenario, settings)
    known = make_rule(grammar.clauses, grammar.actions[0], grammar.vocabulary).mask()
    foreign = (rules.mask & ~known).any(axis=-1) | ~np.isin(rules.action, grammar.actions)
    if foreign.any():
        agent, index = (int(place) for place in np.argwhere(foreign)[0])
        raise InputError(f"rules: '{rules.text(agent, index)}' cannot be said in grammar={settings.rules.grammar}")


def evolve(*settings: Settings, report: Report | None = None) -> list[RunSummary]:
    """Evolve a run for each of the settings, together in one batch where they can share one; `driver.evolve`.

    A run whose `run_dir` is set leaves a run folder there; `read_run` reads it. If it holds the same run already, that
    goes on, or is returned if it is finished. Ctrl-C saves everything first.
    """
    if not settings:
        raise InputError("settings: none given; at least one is required")
    for one in settings:
        of_kind("settings", one, Settings)
    runtime.configure(settings[0].compute)
    return driver.evolve(settings, report=report)


def evaluate(
    settings: Settings, solution: SavedSolution, *, deployments: int = 1, report: Report | None = None
) -> EvaluationSummary:
    """Deploy a saved solution in the scenarios of `settings.instances` seeds; `driver.evaluate`."""
    of_kind("settings", settings, Settings)
    of_kind("solution", solution, SavedSolution)
    deployments = whole("deployments", deployments, 1, MOST_DEPLOYMENTS)
    runtime.configure(settings.compute)
    return driver.evaluate(settings, solution, deployments=deployments, report=report)
