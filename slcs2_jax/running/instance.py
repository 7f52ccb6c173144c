"""What asks for deployments: a search with the measurement of its winner, and a finished solution's evaluation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from slcs2_jax.grammar import RuleSets
from slcs2_jax.rollout import Done, Job
from slcs2_jax.search.evaluation import Deployment, fresh_deployment_key
from slcs2_jax.search.member import Member
from slcs2_jax.search.packing import pack_deployments, unpack_deployments
from slcs2_jax.search.slcs2 import HistoryRow, Search
from slcs2_jax.swarm.task import Delivery, Score
from slcs2_jax.world.scenario import Scenario

Name = tuple[str, int, int]  # stage, generation, deployment


@dataclass(frozen=True, eq=False)
class Site:
    """Where deployments take place, and how an episode is scored."""

    scenario: Scenario
    channels: tuple[int, ...]
    packets: int
    task: Delivery

    def job(self, name: Name, rules: RuleSets, key: tuple) -> Job:
        """One deployment of a solution here."""
        return Job(name, self.scenario, self.channels, rules, key)

    def score(self, done: Done) -> Deployment:
        """What the deployment measured, with its fitness by the task."""
        score = Score(
            delivered=done.delivered,
            packets=self.packets,
            steps=done.steps,
            time_limit=self.scenario.time_limit,
            measures=done.measures,
        )
        assert done.figures is not None
        return Deployment(
            fitness=self.task.fitness(score),
            delivered=done.delivered,
            steps=done.steps,
            contribution=done.contribution,
            **vars(done.figures),
        )


class Task(Protocol):
    """Something that needs deployments until it is finished."""

    site: Site

    @property
    def finished(self) -> bool:
        """Whether nothing more is needed."""
        ...

    @property
    def expected_fitness(self) -> float:
        """How likely deployments beyond the certain ones are to count: a fitness."""
        ...

    @property
    def useful_steps(self) -> int:
        """Time-steps of the deployments that counted so far."""
        ...

    def wanted(self, ahead: int) -> list[Name]:
        """Deployments not yet taken: those certain to count and up to ``ahead`` more that may."""
        ...

    def job(self, name: Name) -> Job:
        """What to compute for a wanted deployment."""
        ...

    def take(self, name: Name, done: Done) -> None:
        """Receive a wanted deployment."""
        ...


@dataclass(eq=False)
class Measurement:
    """A solution deployed again and again on one site, with fresh randomness."""

    site: Site
    rules: RuleSets
    count: int
    taken: dict[int, Deployment] = field(default_factory=dict)

    @property
    def finished(self) -> bool:
        """All deployments are in."""
        return len(self.taken) == self.count

    @property
    def expected_fitness(self) -> float:
        """Nothing is speculative here."""
        return 0.0

    @property
    def deployments(self) -> list[Deployment]:
        """Those taken, in order."""
        return [self.taken[index] for index in sorted(self.taken)]

    @property
    def useful_steps(self) -> int:
        """Time-steps of those taken: all count."""
        return sum(one.steps for one in self.taken.values())

    def wanted(self, ahead: int) -> list[Name]:
        """All that are missing; they are all certain."""
        return [("fresh", 0, index) for index in range(self.count) if index not in self.taken]

    def job(self, name: Name) -> Job:
        """One fresh deployment."""
        return self.site.job(name, self.rules, fresh_deployment_key(self.site.scenario.seed, name[2]))

    def take(self, name: Name, done: Done) -> None:
        """Receive one."""
        deployment = self.site.score(done)
        deployment.check(f"seed {self.site.scenario.seed}, fresh deployment {name[2]}")
        self.taken[name[2]] = deployment


class Instance:
    """One instance: a search to its last generation, then its winner over fresh deployments."""

    def __init__(self, search: Search, site: Site, fresh: int, record: Callable[[HistoryRow], None]) -> None:
        """``record`` is told every generation's row."""
        self.search = search
        self.site = site
        self.evaluations = 0
        self.env_steps = 0
        self.measurement: Measurement | None = None
        self._fresh = fresh
        self._record = record
        self._begin()

    def _begin(self) -> None:
        """Turn to the solution that the search asks for, or to its winner once it asks for no more."""
        self.measurement = None
        if self.search.finished:
            winner = self.winner.solution
            self.measurement = Measurement(self.site, RuleSets(winner.mask, winner.action), self._fresh)
            return
        self._trial = self.search.trial()
        solution = self.search.ask()
        self._rules = RuleSets(solution.mask, solution.action)
        self._parent = next((m.fitness for m in self.search.members if m.generation == solution.parent), 0.0)

    @property
    def useful_steps(self) -> int:
        """Time-steps that counted, those of the winner's measurement too."""
        return self.env_steps + (0 if self.measurement is None else self.measurement.useful_steps)

    @property
    def winner(self) -> Member:
        """The best solution so far."""
        return self.search.best

    @property
    def finished(self) -> bool:
        """The search has ended and its winner is measured."""
        return self.measurement is not None and self.measurement.finished

    @property
    def expected_fitness(self) -> float:
        """The fitness to expect: the parent's."""
        return self._parent

    def wanted(self, ahead: int) -> list[Name]:
        """Deployments of the present solution, then of the winner."""
        if self.measurement is not None:
            return self.measurement.wanted(ahead)
        return [("search", self.search.generation, index) for index in self._trial.wanted(ahead)]

    def job(self, name: Name) -> Job:
        """What to compute."""
        if self.measurement is not None:
            return self.measurement.job(name)
        return self.site.job(name, self._rules, self.search.deployment_key(name[2]))

    def take(self, name: Name, done: Done) -> None:
        """Receive a deployment; a complete evaluation ends the generation."""
        if self.measurement is not None:
            self.measurement.take(name, done)
            return
        self._trial.add(name[2], self.site.score(done))
        if not self._trial.complete:
            return
        evaluation = self._trial.result()
        self.evaluations += evaluation.deployments
        self.env_steps += round(evaluation.steps * evaluation.deployments)
        self._record(self.search.tell(evaluation))
        self._begin()

    @property
    def _taken(self) -> dict[int, Deployment]:
        return self._trial.held if self.measurement is None else self.measurement.taken

    @property
    def progress(self) -> tuple[int, int]:
        """Generations told, and deployments taken since; another one whenever there is something new to save."""
        return self.search.generation, len(self._taken)

    def state(self) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Everything the run needs to go on exactly, between two deployments: arrays, and a JSON-able dictionary.

        Deployments that are being computed are left out: they follow from their keys and are computed again.
        """
        arrays, meta = self.search.state()
        shape = self._rules.action.shape
        arrays = {f"search.{name}": array for name, array in arrays.items()}
        taken = pack_deployments(self._taken, (shape[0], shape[1]))
        arrays |= {f"taken.{name}": array for name, array in taken.items()}
        return arrays, {
            "search": meta,
            "evaluations": self.evaluations,
            "env_steps": self.env_steps,
            "measuring": self.measurement is not None,
        }

    def restore(self, arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]) -> None:
        """Become the run that state() was taken from. Where the search goes further than that one did, it goes on and
        the measurement of the former winner is dropped."""
        parts: dict[str, dict[str, np.ndarray]] = {"search": {}, "taken": {}}
        for name, array in arrays.items():
            part, _, rest = name.partition(".")
            parts[part][rest] = array
        self.search.restore(parts["search"], meta["search"])
        self.evaluations, self.env_steps = int(meta["evaluations"]), int(meta["env_steps"])
        self._begin()
        if meta["measuring"] != (self.measurement is not None):
            return
        for index, deployment in unpack_deployments(parts["taken"]).items():
            if self.measurement is None:
                self._trial.add(index, deployment)
            else:
                self.measurement.taken[index] = deployment
