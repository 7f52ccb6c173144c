"""One run of the search: one new solution per generation, asked for and told (spec 8; paper, Behaviour Evolution)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.config.arguments import whole
from slcs2_jax.search.ailta import Ailta
from slcs2_jax.search.collection import Collection
from slcs2_jax.search.evaluation import (
    PURPOSE_RULES,
    PURPOSE_SEARCH,
    Evaluation,
    Trial,
    deployment_key,
    seed_sequence,
)
from slcs2_jax.search.member import Acceptance, Member
from slcs2_jax.search.offspring import offspring
from slcs2_jax.search.packing import pack_members, pack_solutions, unpack_members, unpack_solutions
from slcs2_jax.search.solution import Origin, Solution, initial_solution
from slcs2_jax.search.supply import RuleSource, RuleSupply

if TYPE_CHECKING:
    from slcs2_jax.config import Search as SearchSettings


@dataclass(frozen=True, eq=False)
class HistoryRow:
    """What one generation of a run brought."""

    generation: int  # from 0
    fitness: float  # mean of the newcomer over its deployments
    deployments: int  # that counted
    delivered: float  # mean packets at the sink
    steps: float  # mean time-steps
    best: float  # greatest mean fitness so far, the newcomer included
    best_generation: int  # whose that is (the earliest on ties)
    size: int  # members after the newcomer was considered
    novelty: float  # mean Delta b of the newcomer to the members it met; NaN in generation 0
    accepted: bool
    removed: int  # members that left for it
    parent: int  # generation of the newcomer's parent; -1 for the first
    explorations: int  # phi of that parent before this attempt
    copied: int  # rules of the newcomer that came from other agents in this generation
    fresh: int  # random rules new in this generation
    contribution: tuple[float, ...]  # [n] mean contribution of each agent


def make_acceptance(settings: SearchSettings, *, agents: int, rules: int) -> Acceptance:
    """The acceptance that the settings name: 'domination' (the collection) or 'ailta'."""
    if settings.acceptance == "domination":
        return Collection(agents=agents, rules=rules, omega0=settings.omega0)
    if settings.acceptance == "ailta":
        return Ailta(
            rejections=settings.ailta_rejections,
            threshold=settings.ailta_threshold,
            threshold_max=settings.ailta_threshold_max,
            patience=settings.ailta_patience,
        )
    raise InputError(f"search.acceptance = {settings.acceptance!r}; 'domination' or 'ailta' is accepted")


class Search:
    """One run: ask() for a solution, evaluate it, tell() the evaluation; repeat until `finished`."""

    def __init__(self, settings: SearchSettings, *, agents: int, rules: int, seed: int, source: RuleSource) -> None:
        """The whole run follows from the settings, the sizes, `seed`, and the evaluations told.

        source(count, rng) draws random rules. Raises InputError for sizes or a seed that are not accepted.
        """
        agents, rules = whole("agents", agents, 1, 64), whole("rules", rules, 1, 1000)
        seed = whole("seed", seed, 0, 2**64 - 1)
        self._settings, self._shape, self._seed = settings, (agents, rules), seed
        self._supply = RuleSupply(source, seed_sequence(seed, PURPOSE_RULES))
        self._rng = np.random.Generator(np.random.PCG64(seed_sequence(seed, PURPOSE_SEARCH)))
        self._acceptance = make_acceptance(settings, agents=agents, rules=rules)
        self._generation = 0
        self._pending: Solution | None = None
        self._pending_explorations = 0
        self._best: Member | None = None

    @property
    def seed(self) -> int:
        return self._seed

    @property
    def generation(self) -> int:
        """The generation whose solution is asked for next or being evaluated; the number of those told."""
        return self._generation

    @property
    def finished(self) -> bool:
        return self._generation >= self._settings.generations

    @property
    def best(self) -> Member:
        """The fittest solution so far (the earliest on ties) with its evaluation."""
        if self._best is None:
            raise InputError("search: no solution was evaluated yet")
        return self._best

    @property
    def members(self) -> list[Member]:
        """The solutions under exploration, oldest first."""
        return self._acceptance.members()

    def ask(self) -> Solution:
        """The solution to evaluate now; the same one until it is told. Raises InputError once the run is finished."""
        if self._pending is None:
            if self.finished:
                raise InputError(f"search: all {self._settings.generations} generations are done")
            self._pending = self._first() if self._generation == 0 else self._next()
        return self._pending

    def _first(self) -> Solution:
        agents, rules = self._shape
        return initial_solution(agents, rules, self._supply)

    def _next(self) -> Solution:
        parent, self._pending_explorations = self._acceptance.parent()
        return offspring(
            parent.solution,
            parent.evaluation,
            explorations=self._pending_explorations,
            generation=self._generation,
            varrho=self._settings.varrho,
            exchange=self._settings.exchange,
            supply=self._supply,
            rng=self._rng,
        )

    def trial(self) -> Trial:
        """An empty evaluation for the solution that ask() gives."""
        return Trial(
            min_deployments=self._settings.min_deployments,
            max_redeployments=self._settings.max_redeployments,
            name=f"run with seed {self._seed}, generation {self._generation}",
        )

    def deployment_key(self, deployment: int) -> tuple[np.uint32, np.uint32]:
        """Episode key of a deployment of the solution that ask() gives."""
        return deployment_key(self._seed, self._generation, deployment)

    def tell(self, evaluation: Evaluation) -> HistoryRow:
        """Take the evaluation of the solution asked for; ends the generation. InputError if none was, or on NaN."""
        if self._pending is None:
            raise InputError("search: tell() without ask(); there is no solution under evaluation")
        evaluation.check(*self._shape, name=f"run with seed {self._seed}, generation {self._generation}")
        solution, newcomer = self._pending, Member(self._pending, evaluation)
        verdict = self._acceptance.consider(newcomer)
        if self._best is None or newcomer.fitness > self._best.fitness:
            self._best = newcomer
        new = solution.origin_generation == self._generation
        copied = int((new & (solution.origin_kind == Origin.COPIED)).sum())
        row = HistoryRow(
            generation=self._generation,
            fitness=evaluation.fitness,
            deployments=evaluation.deployments,
            delivered=evaluation.delivered,
            steps=evaluation.steps,
            best=self._best.fitness,
            best_generation=self._best.generation,
            size=verdict.size,
            novelty=verdict.novelty,
            accepted=verdict.accepted,
            removed=len(verdict.removed),
            parent=solution.parent,
            explorations=self._pending_explorations,
            copied=copied,
            fresh=int(new.sum()) - copied,
            contribution=tuple(evaluation.contribution.tolist()),
        )
        self._pending, self._pending_explorations = None, 0
        self._generation += 1
        return row

    def state(self) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Everything a run needs to go on exactly: arrays, and a JSON-able dictionary; before or after ask()."""
        members = self._acceptance.members()
        best = next((place for place, member in enumerate(members) if member is self._best), None)
        held = members if best is not None or self._best is None else [*members, self._best]
        pending = [] if self._pending is None else [self._pending]
        arrays = {f"members.{name}": array for name, array in pack_members(held).items()}
        arrays |= {f"pending.{name}": array for name, array in pack_solutions(pending, self._shape).items()}
        meta = {
            "seed": self._seed,
            "shape": list(self._shape),
            "generation": self._generation,
            "pending_explorations": self._pending_explorations,
            "members": len(members),
            "best": None if self._best is None else (best if best is not None else len(members)),
            "acceptance": self._acceptance.state(),
            "rng": self._rng.bit_generator.state,
            "supply": self._supply.state(),
        }
        return arrays, meta

    def restore(self, arrays: dict[str, np.ndarray], meta: dict[str, Any]) -> None:
        """Become the run that state() was taken from, if this one has the same settings (more generations are allowed)
        and rule source. Raises InputError if that one was of other sizes or another seed."""
        if (list(self._shape), self._seed) != (list(meta["shape"]), meta["seed"]):
            raise InputError(
                f"search: the state is that of a run of {meta['shape']} agents and rules with seed {meta['seed']}; "
                f"accepted is {list(self._shape)} with seed {self._seed}"
            )
        parts = {
            part: {name.split(".", 1)[1]: array for name, array in arrays.items() if name.startswith(f"{part}.")}
            for part in ("members", "pending")
        }
        held = unpack_members(parts["members"])
        pending = unpack_solutions(parts["pending"])
        self._acceptance.restore(held[: meta["members"]], meta["acceptance"])
        self._best = None if meta["best"] is None else held[meta["best"]]
        self._pending = pending[0] if pending else None
        self._pending_explorations = meta["pending_explorations"]
        self._generation = meta["generation"]
        self._rng.bit_generator.state = meta["rng"]
        self._supply.restore(meta["supply"])

    @classmethod
    def from_state(
        cls,
        settings: SearchSettings,
        arrays: dict[str, np.ndarray],
        meta: dict[str, Any],
        *,
        source: RuleSource,
    ) -> Search:
        """The run that state() was taken from, under the same settings and rule source."""
        agents, rules = meta["shape"]
        search = cls(settings, agents=agents, rules=rules, seed=meta["seed"], source=source)
        search.restore(arrays, meta)
        return search
