"""One instance of a run: a search to its last generation, then its winner over fresh deployments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.config.field import refuse
from slcs2_jax.grammar import RuleSets
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.rollout import Done, Job
from slcs2_jax.running.task import Measurement, Name, Site
from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.history import History, HistoryRow
from slcs2_jax.search.keys import deployment_key
from slcs2_jax.search.member import Member
from slcs2_jax.search.packing import pack_deployments, pack_state, part_of, unpack_deployments, unpack_state
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.protocol import Search, Trial
from slcs2_jax.search.solution import Solution

AHEAD = 10**6  # further than any deployment is computed ahead


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A solution under evaluation."""

    solution: Solution
    policy: BoundPolicy
    trial: Trial


class Instance:
    """A search and what it is evaluated by.

    The solutions that it asks for are deployed side by side. It is told of all of them at once, in their order, when
    the last one's evaluation is complete; so in which order deployments arrive decides nothing.
    """

    def __init__(
        self,
        search: Search,
        problem: Problem,
        site: Site,
        ready: Callable[[RuleSets], BoundPolicy],
        record: Callable[[HistoryRow], None],
    ) -> None:
        """`ready` makes rule-sets deployable, or refuses them; `record` is told the row of every solution."""
        self.search = search
        self.site = site
        self.evaluations = 0
        self.env_steps = 0
        self.measurement: Measurement | None = None
        self._problem, self._ready, self._record = problem, ready, record
        self._history = History()
        self._candidates: dict[int, _Candidate] = {}
        self._begin()

    def _begin(self) -> None:
        """Turn to the solutions that the search asks for, or to its winner once it asks for no more."""
        self.measurement, self._candidates = None, {}
        if self.search.finished:
            winner = self._ready(self.winner.solution.rules)
            worlds, fresh = self._problem.worlds, self._problem.settings.fresh_deployments
            self.measurement = Measurement(self.site, winner, worlds * -(-fresh // worlds))  # alike in all worlds
            return
        asked = self.search.ask(self._problem.settings.batch)
        if not asked:
            raise refuse("search", self._problem.settings.name, "a search that gives a solution until it is finished")
        for generation, solution in enumerate(asked, start=self.search.generation):
            self._problem.check(solution, generation)
            trial = self.search.trial(solution)
            self._candidates[generation] = _Candidate(solution, self._ready(solution.rules), trial)
        parents = {candidate.solution.parent for candidate in self._candidates.values()}
        known = [member.fitness for member in self.search.members if member.generation in parents]
        self._expected = max(known, default=0.0)

    @property
    def policy(self) -> BoundPolicy:
        """The first solution under evaluation, or the winner."""
        if self.measurement is not None:
            return self.measurement.policy
        return next(iter(self._candidates.values())).policy

    @property
    def generation(self) -> int:
        """Solutions that the search was told of."""
        return self.search.generation

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
        """That of the fittest parent; 0 if there is none."""
        return self._expected

    def wanted(self, ahead: int) -> list[Name]:
        """Deployments of the solutions under evaluation, then of the winner."""
        if self.measurement is not None:
            return self.measurement.wanted(ahead)
        return [
            ("search", generation, index)
            for generation, candidate in self._candidates.items()
            for index in candidate.trial.wanted(ahead)
        ]

    def wants(self, name: Name) -> bool:
        """May this deployment still count?"""
        if self.measurement is not None:
            return self.measurement.wants(name)
        candidate = self._candidates.get(name[1])
        return candidate is not None and name[2] in candidate.trial.wanted(AHEAD)

    def job(self, name: Name) -> Job:
        """What to compute."""
        if self.measurement is not None:
            return self.measurement.job(name)
        key = deployment_key(self._problem.seed, name[1], name[2])
        return self.site.job(name, self._candidates[name[1]].policy, key)

    def take(self, name: Name, done: Done) -> None:
        """Receive a deployment; the search is told once all evaluations are complete."""
        if self.measurement is not None:
            self.measurement.take(name, done)
            return
        self._candidates[name[1]].trial.add(name[2], self.site.score(done))
        candidates = list(self._candidates.values())
        if all(candidate.trial.complete for candidate in candidates):
            self._tell(
                [candidate.solution for candidate in candidates], [candidate.trial.result() for candidate in candidates]
            )
            self._begin()

    def _tell(self, solutions: Sequence[Solution], evaluations: Sequence[Evaluation]) -> None:
        verdicts = self.search.tell(solutions, evaluations)
        if len(verdicts) != len(solutions):
            name = self._problem.settings.name
            raise InputError(f"search={name}: tell() returned {len(verdicts)} verdicts for {len(solutions)} solutions")
        for solution, evaluation, verdict in zip(solutions, evaluations, verdicts, strict=True):
            self.evaluations += evaluation.deployments
            self.env_steps += round(evaluation.steps * evaluation.deployments)
            self._record(self._history.row(solution, evaluation, verdict))

    def _taken(self) -> dict[tuple[int, int], Any]:
        """Deployments taken since the search was told last, by generation and number."""
        if self.measurement is not None:
            return {(0, index): deployment for index, deployment in self.measurement.taken.items()}
        return {
            (generation, index): deployment
            for generation, candidate in self._candidates.items()
            for index, deployment in candidate.trial.held.items()
        }

    @property
    def progress(self) -> tuple[int, int]:
        """Generations told, and deployments taken since; another one whenever there is something new to save."""
        return self.search.generation, len(self._taken())

    def state(self) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Everything the instance needs to go on exactly, between two deployments: arrays, and JSON-able values.

        Deployments that are being computed are left out: they follow from their keys and are computed again.
        """
        arrays, search = pack_state(self.search.state())
        taken = pack_deployments(self._taken(), self._problem.shape)
        named = {f"search.{name}": array for name, array in arrays.items()}
        named |= {f"taken.{name}": array for name, array in taken.items()}
        known = self._history.best_generation >= 0
        return named, {
            "search": search,
            "seed": self._problem.seed,
            "evaluations": self.evaluations,
            "env_steps": self.env_steps,
            "best": [self._history.best, self._history.best_generation] if known else None,
            "measuring": self.measurement is not None,
        }

    def restore(self, arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]) -> None:
        """Become the instance that state() was taken from. Where the search goes further than that one did, it goes on
        and the measurement of the former winner is dropped."""
        self.search.restore(unpack_state(part_of(arrays, "search"), meta["search"], self._problem.vocabulary))
        self.evaluations, self.env_steps = int(meta["evaluations"]), int(meta["env_steps"])
        self._history = History(*(meta["best"] or ()))
        self._begin()
        if meta["measuring"] != (self.measurement is not None):
            return
        for (generation, index), deployment in unpack_deployments(part_of(arrays, "taken")).items():
            if self.measurement is None:
                self._candidates[generation].trial.add(index, deployment)
            else:
                self.measurement.taken[index] = deployment
