"""A row for each solution that a search evaluated: what generations.jsonl holds."""

from __future__ import annotations

from dataclasses import dataclass

from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.solution import Origin, Solution


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
    novelty: float  # mean Delta b of the newcomer to the members it met; NaN if it met none
    accepted: bool
    removed: int  # members that left for it
    parent: int  # generation of the newcomer's parent; -1 if it has none
    explorations: int  # phi of that parent before this attempt
    copied: int  # rules of the newcomer that came from other agents in this generation
    fresh: int  # random rules new in this generation
    contribution: tuple[float, ...]  # [n] mean contribution of each agent


class History:
    """Makes the rows of a search, which needs to know the best so far."""

    def __init__(self, best: float = float("-inf"), best_generation: int = -1) -> None:
        self.best, self.best_generation = best, best_generation

    def row(self, solution: Solution, evaluation: Evaluation, verdict: Verdict) -> HistoryRow:
        """The row of the solution that was evaluated next."""
        if evaluation.fitness > self.best:
            self.best, self.best_generation = evaluation.fitness, solution.generation
        new = solution.origin_generation == solution.generation
        copied = int((new & (solution.origin_kind == Origin.COPIED)).sum())
        return HistoryRow(
            generation=solution.generation,
            fitness=evaluation.fitness,
            deployments=evaluation.deployments,
            delivered=evaluation.delivered,
            steps=evaluation.steps,
            best=self.best,
            best_generation=self.best_generation,
            size=verdict.size,
            novelty=verdict.novelty,
            accepted=verdict.accepted,
            removed=len(verdict.removed),
            parent=solution.parent,
            explorations=verdict.explorations,
            copied=copied,
            fresh=int(new.sum()) - copied,
            contribution=tuple(evaluation.contribution.tolist()),
        )
