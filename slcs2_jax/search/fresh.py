"""Random search within another search: children have nothing of their parents but reflexes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.member import Member
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.solution import Solution
from slcs2_jax.search.supply import RuleSupply


class Fresh:
    """Random rules for every agent; what a variation must be compared with. Reflexes are the parent's."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem

    def __call__(
        self,
        parent: Solution,
        evaluation: Evaluation,
        *,
        explorations: int,
        generation: int,
        members: Sequence[Member],
        supply: RuleSupply,
        rng: np.random.Generator,
    ) -> Solution:
        """See `Variation`."""
        made = self._problem.random_solution(supply, generation)
        values = {name: array[: parent.shape[0]] for name, array in made.arrays().items()}
        if parent.rules.reflex is not None:
            values["reflex"] = parent.rules.reflex.copy()
        return Solution.of(values | {"generation": generation, "parent": parent.generation}, parent.rules.vocabulary)
