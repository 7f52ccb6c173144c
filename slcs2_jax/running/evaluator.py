"""Many policies in many scenarios, in one call and in one batch."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax import runtime
from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.field import refuse
from slcs2_jax.results import Report
from slcs2_jax.results.progress import counted
from slcs2_jax.running.batches import Rollouts, make_batches, slots_per_device
from slcs2_jax.running.deployable import Deployable, bound, program, rules_of
from slcs2_jax.running.memory import check_memory, measurement_bytes
from slcs2_jax.running.schedule import play
from slcs2_jax.running.task import Measurement, Site
from slcs2_jax.running.usage import Usage
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.world.scenario import Scenario, check_scenario, make_scenario

MOST_DEPLOYMENTS = 10**6

Measure = Callable[[Deployment, Scenario], Any]


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluations:
    """What was measured: P policies in S scenarios, D deployments in each. n = agents.

    Attributes:
        fitness: float64 [P, S, D].
        delivered: int64 [P, S, D], packets at the sink.
        steps: int64 [P, S, D], time-steps done.
        contribution: int64 [P, S, D, n], delivered packets that each agent had held.
        measures: by name, what the caller's own measures gave, [P, S, D, ...].
        deployments: the same one by one, with the figures of every rule: `deployments[p][s][d]`.
        usage: where the time went.
    """

    fitness: NDArray[np.float64]
    delivered: NDArray[np.int64]
    steps: NDArray[np.int64]
    contribution: NDArray[np.int64]
    measures: Mapping[str, NDArray[Any]]
    deployments: Sequence[Sequence[Sequence[Deployment]]]
    usage: Usage = field(default_factory=Usage)

    @property
    def mean(self) -> NDArray[np.float64]:
        """Mean fitness of each policy over all its deployments, [P]."""
        return self.fitness.mean(axis=(1, 2))


class Evaluator:
    """Evaluates policies of any kind in any scenarios; to be kept and called again and again.

    Programs are compiled at the first call and again only when a later one needs more room: more walls, more channels,
    more rules, or far more slots.

        evaluator = slcs2_jax.Evaluator(settings)
        result = evaluator([best, behaviour], range(30), deployments=4)
        result.mean

    A measure of the caller's own is a function of a deployment and its scenario that returns a number or an array, of
    the same shape each time: `measures={"pace": lambda deployment, scenario: deployment.delivered / deployment.steps}`.
    `deployment.measures` has what the task took from the last state (`Delivery.measure`).
    """

    def __init__(self, settings: Settings, *, measures: Mapping[str, Measure] | None = None) -> None:
        """Compiles nothing yet.

        Args:
            settings: radio, swarm, learning, rules and compute; of the world what `make_scenario` needs for seeds, and
                the thickness of walls.
            measures: of the caller's own, by name.

        Raises:
            InputError: an argument of another kind.
        """
        self.settings = of_kind("settings", settings, Settings)
        self._measures = dict(measures or {})
        for name, measure in self._measures.items():
            if not callable(measure):
                raise refuse(f"measures[{name}]", type(measure).__name__, "a function of a deployment and its scenario")
        runtime.configure(settings.compute)
        self._rollouts = Rollouts(settings)

    def __call__(
        self,
        policies: Sequence[Deployable],
        scenarios: Sequence[Scenario | int] | None = None,
        *,
        deployments: int = 1,
        report: Report | None = None,
    ) -> Evaluations:
        """Deploy every policy in every scenario so many times.

        Args:
            policies: rule-sets, solutions of a search or of files, decision lists, bound policies, in any mixture.
            scenarios: from `make_scenario`, made by hand, or seeds; by default those of the settings' instances.
            deployments: of each policy in each scenario; deployment i is the same in every call, and differs from those
                of any search.
            report: who is told of progress.

        Raises:
            InputError: nothing to evaluate; a policy or scenario that the settings do not fit; or a measure that is not
                finite or changes its shape.
        """
        count = whole("deployments", deployments, 1, MOST_DEPLOYMENTS)
        places = self._scenarios(scenarios)
        if not isinstance(policies, Sequence) or not policies:
            raise refuse("policies", type(policies).__name__, "a sequence of at least one policy")
        return self.at([Site.of(scenario, self.settings) for scenario in places], policies, count, report)

    def at(
        self, sites: Sequence[Site], policies: Sequence[Deployable], count: int, report: Report | None = None
    ) -> Evaluations:
        """Deploy every policy so many times on sites of any settings that can share a batch with this one's.

        Raises:
            InputError: a policy that does not fit, or a measure as above.
        """
        ready = [bound(policy, self.settings, f"policies[{at}]") for at, policy in enumerate(policies)]
        tasks = [[Measurement(site, policy, count) for site in sites] for policy in ready]
        usage = self._play([task for row in tasks for task in row], report)
        return self._collected(tasks, usage)

    def _scenarios(self, scenarios: Sequence[Scenario | int] | None) -> list[Scenario]:
        """The scenarios that are meant, each checked against the settings."""
        settings = self.settings
        given = range(settings.seed, settings.seed + settings.instances) if scenarios is None else scenarios
        if not isinstance(given, Sequence) or not given:
            raise refuse("scenarios", type(given).__name__, "a sequence of at least one scenario or seed")
        found = [
            one if isinstance(one, Scenario) else make_scenario(settings, one) for one in counted(given, "worlds made:")
        ]
        for scenario in found:
            check_scenario(scenario, settings)
        return found

    def _play(self, tasks: Sequence[Measurement], report: Report | None) -> Usage:
        """Compute all deployments; policies that one program serves share their slots."""

        def tell() -> None:
            if report is None:
                return
            report.generation(
                done=[len(task.taken) for task in tasks],
                best=[max((one.fitness for one in task.taken.values()), default=math.nan) for task in tasks],
                evaluations=sum(len(task.taken) for task in tasks),
                env_steps=sum(task.useful_steps for task in tasks),
            )

        groups: dict[Any, list[Measurement]] = {}
        programs = {id(policy): program(policy) for policy in {id(task.policy): task.policy for task in tasks}.values()}
        for task in tasks:
            groups.setdefault(programs[id(task.policy)], []).append(task)
        usage = Usage()
        try:
            for group in groups.values():
                size = rules_of(group[0].policy) or self.settings.rules.rules
                sized = replace(self.settings, rules=replace(self.settings.rules, rules=size))
                episodes = sum(task.count for task in group)
                width, devices = slots_per_device(sized, episodes), runtime.devices(sized.compute)
                check_memory(sized, measurement_bytes(sized, len(group), episodes), width * len(devices), devices)
                note = report.note if report is not None else lambda text: None
                usage += play(make_batches(sized, group, width=width, rollouts=self._rollouts, note=note), tell)
        except BaseException:
            self._rollouts.forget()
            raise
        return usage

    def _collected(self, tasks: Sequence[Sequence[Measurement]], usage: Usage) -> Evaluations:
        found = [[task.deployments for task in row] for row in tasks]

        def gather(value: Callable[[Deployment], Any], dtype: type) -> NDArray[Any]:
            return np.array([[[value(one) for one in each] for each in row] for row in found], dtype)

        return Evaluations(
            fitness=gather(lambda one: one.fitness, np.float64),
            delivered=gather(lambda one: one.delivered, np.int64),
            steps=gather(lambda one: one.steps, np.int64),
            contribution=gather(lambda one: one.contribution, np.int64),
            measures={name: _measured(name, measure, tasks) for name, measure in self._measures.items()},
            deployments=found,
            usage=usage,
        )


def _measured(name: str, measure: Measure, tasks: Sequence[Sequence[Measurement]]) -> NDArray[Any]:
    """A measure of every deployment, [P, S, D, ...]. Raises InputError naming it."""
    values = [
        [[np.asarray(measure(one, task.site.scenario)) for one in task.deployments] for task in row] for row in tasks
    ]
    shapes = {value.shape for row in values for each in row for value in each}
    if len(shapes) > 1:
        raise InputError(f"measures[{name}]: returned shapes {sorted(shapes)}; accepted is one shape")
    gathered = np.array(values)
    if gathered.dtype.kind not in "biuf" or not np.isfinite(gathered).all():
        raise InputError(f"measures[{name}]: returned something that is no finite number; accepted are those alone")
    return gathered
