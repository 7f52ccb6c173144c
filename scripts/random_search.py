"""Random search with the budget of evolution: python scripts/random_search.py RUNS OUT.

Every generation is a new random solution in the same world, evaluated by the same rule (re-deployment while the mean
fitness is above 0). Each instance goes on until it has spent the evaluations that it spent in RUNS, which is the folder
of a run or one with runs below it. Each run's counterpart in OUT is a run folder like any other; the rows of its
generations.jsonl compare with those of the run. Interrupted, the same command goes on.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import InputError
from slcs2_jax.results import FinishedRun, Progress, read_run
from slcs2_jax.results.sweep import runs_below
from slcs2_jax.search import Evaluation, HistoryRow, Search, Solution, initial_solution


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


def budgets_of(runs: Sequence[FinishedRun]) -> dict[int, int]:
    """Evaluations that the instance of each seed spent."""
    found: dict[int, int] = {}
    for run in runs:
        if run.summary is None:
            raise InputError(f"run={run.path}: is not finished; accepted is a folder with a summary.json")
        for one in run.summary["instances"]:
            if one["seed"] in found:
                raise InputError(f"run={run.path}: seed {one['seed']} is there twice; accepted are runs of one world")
            found[one["seed"]] = one["evaluations"]
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=Path, help="folder of finished evolution, or with such folders below it")
    parser.add_argument("out", type=Path, help="folder to make")
    arguments = parser.parse_args()
    evolved = [read_run(str(one.run_dir)) for one in runs_below(arguments.runs)[0]]
    if not evolved:
        raise InputError(f"runs={arguments.runs}: holds no evolution; accepted is the folder of a run or of several")
    budgets = budgets_of(evolved)
    settings = [
        dataclasses.replace(run.settings, run_dir=str(arguments.out / Path(run.path).relative_to(arguments.runs)))
        for run in evolved
    ]
    runtime.configure(settings[0].compute)
    from slcs2_jax.search import driver  # starts JAX

    with Progress(max(budgets.values()), label="solution") as report:
        driver.evolve(settings, report=report, search=partial(RandomSearch, budgets=budgets))


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"random_search: error: {error}")
