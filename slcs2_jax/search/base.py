"""What most searches have in common: numbering, budget, the best so far, the paper's rule of re-deployment, saving."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from slcs2_jax.config import InputError
from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.member import Member
from slcs2_jax.search.noise import Noise
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.protocol import SearchState
from slcs2_jax.search.solution import Solution
from slcs2_jax.search.trial import Race, Trial, WorldRace


class BaseSearch(ABC):
    """A search to derive from: give `propose`, and `consider` if it learns from what it is told.

    Whatever else a derived class must remember goes through `remember` and `recall`. `rng` and `supply` (random rules)
    are saved here; drawing from anything else would not survive an interruption.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.settings = problem.settings
        self.supply, self.rng = problem.supply(), problem.rng()
        self.generation = 0  # solutions told
        self.episodes = 0  # deployments that counted
        self.noise = Noise()  # of deployments of one solution
        self._asked: list[Solution] = []
        self._best: Member | None = None

    # -- what a search gives -------------------------------------------------------------------------------------------

    @abstractmethod
    def propose(self, generation: int) -> Solution:
        """A new solution of this generation."""

    def consider(self, newcomer: Member) -> Verdict:
        """Take in what was evaluated; called for each solution in order."""
        return Verdict()

    @property
    def members(self) -> list[Member]:
        """The solutions held on to, oldest first: the best one alone."""
        return [] if self._best is None else [self._best]

    def remember(self) -> dict[str, Any]:
        """What of its own the search must keep, JSON-able; members, best and what is drawn are kept already."""
        return {}

    def recall(self, members: list[Member], kept: dict[str, Any]) -> None:  # noqa: B027 (most need nothing)
        """Take back members and what `remember` gave."""

    # -- what all do alike ---------------------------------------------------------------------------------------------

    @property
    def finished(self) -> bool:
        """All generations are made, or all episodes spent (`generations`, `search.episodes`)."""
        spent = self.settings.episodes is not None and self.episodes >= self.settings.episodes
        return spent or self.generation >= self.settings.generations

    @property
    def best(self) -> Member:
        """The fittest solution so far (the earliest on ties) with its evaluation."""
        if self._best is None:
            raise InputError("search: no solution was evaluated yet")
        return self._best

    def ask(self, count: int = 1) -> list[Solution]:
        """See `Search.ask`. Raises InputError once the search is finished."""
        if not self._asked:
            if self.finished:
                raise InputError(f"search: all {self.generation} generations are done")
            stop = min(self.generation + max(1, count), self.settings.generations)
            self._asked = [self.propose(generation) for generation in range(self.generation, stop)]
        return list(self._asked)

    def trial(self, solution: Solution) -> Trial:
        """An empty evaluation: re-deployed while the mean fitness is above 0 (paper, Evaluation and Re-Evaluation), or
        with `search.racing` while it may be above that of the best. Of many worlds, deployed in each of them."""
        settings, name = self.settings, self._name(solution.generation)
        if self.problem.worlds > 1:
            return self._through_worlds(name)
        limits = {"min_deployments": settings.min_deployments, "max_redeployments": settings.max_redeployments}
        if not settings.racing:
            return Trial(**limits, name=name)
        rival = float("-inf") if self._best is None else self._best.fitness
        return Race(rival=rival, margin=settings.race_width * self.noise.deviation, **limits, name=name)

    def _through_worlds(self, name: str) -> Trial:
        worlds, kinds = self.problem.worlds, self.problem.kinds
        if not self.settings.racing:
            return Trial(min_deployments=worlds, max_redeployments=worlds - 1, name=name)
        rival = None if self._best is None else self._best.evaluation.by_world(worlds)
        margin = self.settings.race_width * self.noise.deviation
        return WorldRace(rival=rival, margin=margin, kinds=kinds, worlds=worlds, name=name)

    def _fixed(self, solution: Solution, deployments: int) -> Trial:
        """An empty evaluation of exactly so many deployments."""
        name = self._name(solution.generation)
        return Trial(min_deployments=deployments, max_redeployments=deployments - 1, name=name)

    def tell(self, solutions: Sequence[Solution], evaluations: Sequence[Evaluation]) -> list[Verdict]:
        """See `Search.tell`. Raises InputError if these were not asked for, or on NaN; nothing is changed then."""
        if not self._asked:
            raise InputError("search: tell() without ask(); there is no solution under evaluation")
        asked = [solution.generation for solution in self._asked]
        if [solution.generation for solution in solutions] != asked or len(evaluations) != len(asked):
            raise InputError(f"search: tell() accepts the solutions asked for, of generations {asked}, in their order")
        for solution, evaluation in zip(solutions, evaluations, strict=True):
            evaluation.check(*self.problem.shape, name=self._name(solution.generation))
        self._asked = []
        return [self._take(Member(*pair)) for pair in zip(solutions, evaluations, strict=True)]

    def _take(self, newcomer: Member) -> Verdict:
        verdict = self.consider(newcomer)
        self._measure(newcomer.evaluation)
        if self._best is None or (newcomer.fitness > self._best.fitness and newcomer.evaluation.offset is None):
            self._best = newcomer
        self.generation += 1
        self.episodes += newcomer.evaluation.deployments
        return verdict

    def _measure(self, evaluation: Evaluation) -> None:
        """Learn how much deployments of one solution differ; of many worlds, how much differences to the best do."""
        fitnesses = evaluation.fitnesses
        if self.problem.worlds > 1:
            if self._best is None:
                return
            best = self._best.evaluation.by_world(self.problem.worlds)
            fitnesses = tuple(one - best[at % len(best)] for at, one in enumerate(fitnesses))
        self.noise.add(fitnesses)

    def _name(self, generation: int) -> str:
        return f"run with seed {self.problem.seed}, generation {generation}"

    def _knowledge_ids(self) -> list[int]:
        knowledge = self.problem.knowledge
        return [] if knowledge is None else knowledge.rules.ids().ravel().tolist()

    def state(self) -> SearchState:
        """See `Search.state`."""
        return SearchState(
            generation=self.generation,
            members=self.members,
            best=self._best,
            asked=list(self._asked),
            meta={
                "seed": self.problem.seed,
                "shape": list(self.problem.shape),
                "episodes": self.episodes,
                "rng": self.rng.bit_generator.state,
                "supply": self.supply.state(),
                "noise": self.noise.state(),
                "knowledge": self._knowledge_ids(),
                "kept": self.remember(),
                **({"worlds": self.problem.worlds} if self.problem.worlds > 1 else {}),
            },
        )

    def restore(self, state: SearchState) -> None:
        """See `Search.restore`. Raises InputError if the state is of other sizes another seed or other knowledge."""
        meta, mine = state.meta, (list(self.problem.shape), self.problem.seed)
        if mine != (list(meta["shape"]), meta["seed"]):
            raise InputError(
                f"search: the state is that of a run of {meta['shape']} agents and rules with seed {meta['seed']}; "
                f"accepted is {mine[0]} with seed {mine[1]}"
            )
        if (worlds := meta.get("worlds", 1)) != self.problem.worlds:
            raise InputError(f"search: the state is that of a run in {worlds} worlds")
        if meta["knowledge"] != self._knowledge_ids():
            raise InputError("knowledge.rules: is not the list that the run was begun with; accepted is that one")
        self.generation, self.episodes = state.generation, int(meta["episodes"])
        self._best, self._asked = state.best, list(state.asked)
        self.rng.bit_generator.state = meta["rng"]
        self.supply.restore(meta["supply"])
        self.noise.restore(meta["noise"])
        self.recall(state.members, meta["kept"])
