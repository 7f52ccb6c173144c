"""Random search with the budget of evolution: python scripts/random_search.py RUNS OUT.

Each instance of each run in RUNS, which is the folder of a run or one with runs below it, has a counterpart in OUT: a
run of search=random in the same world, with as many episodes as evolution spent there. The counterparts are run folders
like any other, and advance in one batch. Interrupted, the same command goes on.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path

from slcs2_jax.config import InputError, Settings
from slcs2_jax.results import FinishedRun, Progress, read_run
from slcs2_jax.results.sweep import runs_below


def counterparts(run: FinishedRun, folder: Path) -> Iterator[Settings]:
    """For each instance of a finished run, random search with its episodes, below a folder if there are several."""
    if run.summary is None:
        raise InputError(f"run={run.path}: is not finished; accepted is a folder with a summary.json")
    for instance in run.summary["instances"]:
        alone = len(run.summary["instances"]) == 1
        spent = instance["evaluations"]
        # each solution takes an episode at least
        search = dataclasses.replace(run.settings.search, name="random", batch=1, generations=spent, episodes=spent)
        yield dataclasses.replace(
            run.settings,
            search=search,
            seed=instance["seed"],
            instances=1,
            run_dir=str(folder if alone else folder / f"seed_{instance['seed']:03d}"),
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=Path, help="folder of finished evolution, or with such folders below it")
    parser.add_argument("out", type=Path, help="folder to make")
    arguments = parser.parse_args()
    evolved = [read_run(str(one.run_dir)) for one in runs_below(arguments.runs)[0]]
    if not evolved:
        raise InputError(f"runs={arguments.runs}: holds no evolution; accepted is the folder of a run or of several")
    settings = [
        one for run in evolved for one in counterparts(run, arguments.out / run.path.relative_to(arguments.runs))
    ]
    from slcs2_jax import evolve  # starts JAX

    with Progress(max(one.search.generations for one in settings), label="solution") as report:
        evolve(*settings, report=report)


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"random_search: error: {error}")
