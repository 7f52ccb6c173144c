"""What pages show of the runs in a folder: every instance's search; of the best ones, rules and a replay too."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from pathlib import Path

from slcs2_jax.config import InputError
from slcs2_jax.looking.page_data import Shown, by_rank
from slcs2_jax.looking.solutions import best_of, replay
from slcs2_jax.results import FinishedRun, read_run
from slcs2_jax.results.progress import counted
from slcs2_jax.results.run_config import read_config
from slcs2_jax.results.run_folder import folders_with_config

Instance = tuple[Path, int]  # a run's folder and the number of one of its instances


def runs_of_evolution(folder: Path) -> list[FinishedRun]:
    """The runs of evolution in a folder and below it, finished or not. Raises InputError if one is damaged."""
    places = counted(list(folders_with_config(folder)), "runs read:")
    return [read_run(place) for place in places if read_config(place).evolves]


def chosen(runs: list[FinishedRun], replays: int) -> list[Instance]:
    """The instances that get rules and a replay: the best one of each arm in each world first."""
    return [(run.path, instance) for run, instance in by_rank(runs)[:replays]]


def entries(
    run: FinishedRun,
    *,
    replayed: Collection[Instance],
    deployment: int,
    after_chunk: Callable[[int], None] = lambda steps: None,
    passed: list[str] | None = None,
) -> Iterator[Shown]:
    """Every instance of a run, the best one first.

    Args:
        run: of evolution.
        replayed: instances that get a replay and their rules.
        deployment: which is replayed.
        after_chunk: told now and then how many steps of a replay were computed.
        passed: gets a line for each solution that should be shown and cannot be read.
    """
    for _, instance in by_rank([run]):
        if (run.path, instance) not in replayed:
            note = f"Rules and a replay: slcs2 report RUN replays={run.settings.instances}, of its own folder RUN."
            yield Shown(run=run, instance=instance, note=note)
            continue
        try:
            solution = best_of(run, instance)
        except InputError as error:
            if passed is not None:
                passed.append(str(error))
            yield Shown(run=run, instance=instance, note=f"No solution to show: {error}")
            continue
        recording = replay(solution, deployment=deployment, after_chunk=after_chunk)
        yield Shown(run=run, instance=instance, solution=solution, recording=recording, deployment=deployment)
