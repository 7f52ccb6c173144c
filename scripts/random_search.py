"""Random search with the budget of an evolution run: python scripts/random_search.py RUN OUT.

Every generation is a new random solution in the same world, evaluated by the same rule (re-deployment while the mean
fitness is above 0). Each instance goes on until it has spent the evaluations that its instance of RUN spent. OUT
becomes a run folder like any other; the rows of its generations.jsonl compare with those of RUN. Interrupted, the same
command goes on.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import InputError
from slcs2_jax.evolution import Evaluation, HistoryRow, Search, Solution, initial_solution
from slcs2_jax.results import Progress, read_run


class RandomSearch(Search):
    """A search whose solutions have no parents and that ends when its evaluations are spent."""

    def __init__(self, *arguments, seed: int, budgets: Mapping[int, int], **named) -> None:
        super().__init__(*arguments, seed=seed, **named)
        self._left = budgets[seed]

    @property
    def finished(self) -> bool:
        return self._left <= 0

    def _next(self) -> Solution:
        agents, rules = self._shape
        return dataclasses.replace(initial_solution(agents, rules, self._supply), generation=self.generation)

    def tell(self, evaluation: Evaluation) -> HistoryRow:
        self._left -= evaluation.deployments
        return super().tell(evaluation)

    def state(self) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        arrays, meta = super().state()
        return arrays, meta | {"left": self._left}

    def restore(self, arrays: dict[str, np.ndarray], meta: dict[str, Any]) -> None:
        super().restore(arrays, meta)
        self._left = meta["left"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="run folder of a finished evolution")
    parser.add_argument("out", help="run folder to make")
    arguments = parser.parse_args()
    evolved = read_run(arguments.run)
    if evolved.summary is None:
        raise InputError(f"run={arguments.run}: is not finished; accepted is a folder with a summary.json")
    budgets = {one["seed"]: one["evaluations"] for one in evolved.summary["instances"]}
    settings = dataclasses.replace(evolved.settings, run_dir=arguments.out)
    runtime.configure(settings.compute)
    from slcs2_jax.evolution import driver  # starts JAX

    with Progress(max(budgets.values()), label="solution") as report:
        driver.evolve([settings], report=report, search=partial(RandomSearch, budgets=budgets))


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"random_search: error: {error}")
