"""The main jobs from Python: deploy a policy, evolve one, evaluate one in many worlds. Importing this starts JAX.

Each sets JAX up as the command line does (`runtime.configure`), where JAX does not run yet.
"""

from __future__ import annotations

from typing import Any

from slcs2_jax import runtime
from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.chosen import with_search
from slcs2_jax.config.field import refuse
from slcs2_jax.config.registry import KINDS
from slcs2_jax.results import EvaluationSummary, Report, RunSummary
from slcs2_jax.running import driver
from slcs2_jax.running.deployable import Deployable, bound
from slcs2_jax.running.evaluator import MOST_DEPLOYMENTS, Evaluator
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.protocol import MakeSearch
from slcs2_jax.world.scenario import Scenario


def deploy(settings: Settings, scenario: Scenario, policy: Deployable, *, deployments: int = 1) -> list[Deployment]:
    """Episodes of a policy in one scenario, each with randomness of its own (docs/model.md). See `Evaluator` for many.

    Args:
        settings: radio, swarm, learning and rules; of the world the thickness of walls alone is looked at.
        scenario: where, from `make_scenario` or made by hand.
        policy: rule-sets, a solution of a search or of a file, a decision list, or any other policy with its parameters
            (`bind`).
        deployments: how many episodes; episode i is the same in every call.

    Returns:
        For each its fitness, packets delivered, steps, contributions, and what was learnt of every rule (`figures`;
        None for a policy without rules).

    Raises:
        InputError: fewer than one deployment, or a scenario or policy that the settings do not fit.
    """
    of_kind("settings", settings, Settings)
    of_kind("scenario", scenario, Scenario)
    ready = bound(policy, settings)
    [[found]] = Evaluator(settings)([ready], [scenario], deployments=deployments).deployments
    return list(found)


def evolve(
    *settings: Settings, search: str | MakeSearch | None = None, report: Report | None = None
) -> list[RunSummary]:
    """Evolve a run for each of the settings, together in one batch where they can share one; `driver.evolve`.

    A run whose `run_dir` is set leaves a run folder there; `read_run` reads it. If it holds the same run already, that
    goes on, or is returned if it is finished. Ctrl-C saves everything first.

    Args:
        settings: one for each run.
        search: what proposes solutions, in place of what `settings.search.name` says: a name (slcs2, informed, random,
            one that was registered), which brings its parts as `search=` on the command line does (`with_search`); or
            a class or function that makes a search from a `slcs2_jax.search.Problem`, which is registered under its
            own name if it is not yet.
        report: who is told of progress.

    Raises:
        InputError: no settings, an impossible one, or no such search.
    """
    if not settings:
        raise InputError("settings: none given; at least one is required")
    for one in settings:
        of_kind("settings", one, Settings)
    if search is not None:
        name = search if isinstance(search, str) else _registered(search)
        settings = tuple(one if one.search.name == name else with_search(one, name) for one in settings)
    runtime.configure(settings[0].compute)
    return driver.evolve(settings, report=report)


def _registered(make: Any) -> str:
    """The name that a search is registered under; it is taken in under that of its class or function if need be."""
    if not callable(make):
        raise refuse("search", type(make).__name__, "a name, or a class or function that makes a search")
    registry = KINDS["search"]
    for name in registry.names():
        if registry.get(name) is make:
            return name
    made = getattr(make, "func", make)  # look into a functools.partial
    name = str(getattr(made, "__qualname__", type(made).__name__)).rpartition("<locals>.")[2]
    registry.add(name, make, str(getattr(made, "__module__", type(made).__module__)))
    return name


def evaluate(
    settings: Settings, policy: Deployable, *, deployments: int = 1, report: Report | None = None
) -> EvaluationSummary:
    """Deploy a policy (see `deploy`) in the scenarios of `settings.instances` seeds; `driver.evaluate`."""
    of_kind("settings", settings, Settings)
    deployments = whole("deployments", deployments, 1, MOST_DEPLOYMENTS)
    return driver.evaluate(settings, policy, deployments=deployments, report=report)
