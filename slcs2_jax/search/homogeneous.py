"""Swarms whose agents share one rule-set: what is varied is that one, and what is learnt of it is pooled.

With `search.homogeneous` a solution holds the same R rules n times, so that it is deployed, saved and shown as any
other, and each agent learns for itself within an episode. Variation sees a swarm of one:

- **Contribution** of the rule-set is the sum of its agents'. It is its own mean, so the rule-set is never of low
  quality by comparison; it evolves in every generation, as all do where all contribute the same.
- **Exchange** between agents has no meaning: there is no other rule-set to take rules from. `exchange` changes nothing,
  and all that is not kept is drawn at random.
- **Figures** of a rule are means over the agents, each weighted with how often it used the rule (tau); usage is the
  mean. A rule that no agent used has 0, as elsewhere.
"""

from __future__ import annotations

import numpy as np

from slcs2_jax.results.figures import Figures
from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.solution import Solution


def shared_rules(solution: Solution) -> Solution:
    """The first agent's rule-set as a solution for one agent."""
    first = {name: array[:1].copy() for name, array in solution.arrays().items()}
    return Solution.of(solution.values() | first, solution.rules.vocabulary)


def for_all(solution: Solution, agents: int) -> Solution:
    """A solution for one agent given to each of so many."""
    every = {name: np.repeat(array, agents, axis=0) for name, array in solution.arrays().items()}
    return Solution.of(solution.values() | every, solution.rules.vocabulary)


def pooled(evaluation: Evaluation) -> Evaluation:
    """What the agents of one rule-set learnt, as if one had: see the module."""
    figures = evaluation.figures
    usage = figures.usage.astype(np.float64)
    total = usage.sum(axis=0)

    def weighted(name: str) -> np.ndarray:
        added = (getattr(figures, name) * usage).sum(axis=0)
        mean = np.divide(added, total, out=np.zeros_like(added), where=total > 0)
        return mean.astype(np.float32)[None]

    return Evaluation(
        fitnesses=evaluation.fitnesses,
        delivered=evaluation.delivered,
        steps=evaluation.steps,
        contribution_sum=evaluation.contribution_sum.sum(keepdims=True),
        figures=Figures(
            quality=weighted("quality"),
            strength=weighted("strength"),
            error=weighted("error"),
            usage=usage.mean(axis=0).astype(np.float32)[None],
        ),
    )
