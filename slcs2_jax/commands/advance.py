"""What evolve and resume share: advance runs, begun or not, and print what they came to."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config import Compute, Settings
    from slcs2_jax.results import RunSummary


def advance(settings: Sequence[Settings], *, as_begun: bool = False) -> list[RunSummary]:
    """Advance runs together to their ends and print them; `as_begun` as in `finish`."""
    summaries = finish(settings, as_begun=as_begun)
    for summary in summaries:
        print_run(summary)
    return summaries


def finish(settings: Sequence[Settings], *, as_begun: bool = False) -> list[RunSummary]:
    """Advance runs together to their ends; JAX starts only if something is left to do.

    `as_begun`: with the grammars that they were begun with, whatever their files say now.
    """
    from slcs2_jax.results import Progress
    from slcs2_jax.results.reading import ended

    before = [ended(one) for one in settings]
    going = [one for one, summary in zip(settings, before, strict=True) if summary is None]
    if len(going) < len(settings):
        line = "the run is finished" if len(settings) == 1 else f"{len(settings) - len(going)} of the runs are finished"
        print(line if not going else f"{line}, {len(going)} to go", file=sys.stderr)
    if not going:
        return [summary for summary in before if summary is not None]
    from slcs2_jax import runtime

    runtime.configure(_compute(going))
    from slcs2_jax.running import driver

    most = max(run.search.generations for run in going)
    with Progress(most, afterwards="now fresh deployments of the winners") as report:
        summaries: list[RunSummary] = driver.evolve(settings, report=report, as_begun=as_begun)
    return summaries


def _compute(settings: Sequence[Settings]) -> Compute:
    """How JAX must be set up for all of them: with the most devices that any wants."""
    devices = [one.compute.devices for one in settings]
    most = None if None in devices else max(count for count in devices if count is not None)
    return dataclasses.replace(settings[0].compute, devices=most)


def print_run(summary: RunSummary) -> None:
    """A table of its instances, and where the time went."""
    print(f"run folder {terminal(summary.run_dir)}")
    print(f"{'seed':>10} {'best':>8} {'fresh mean':>11} {'fresh sd':>9} {'evaluations':>12} {'env-steps':>14}")
    for i in summary.instances:
        print(
            f"{i.seed:>10} {i.best_fitness:>8.3f} {i.fresh_mean:>11.3f} {i.fresh_sd:>9.3f} "
            f"{i.evaluations:>12,} {i.env_steps:>14,}"
        )
    best = sum(i.best_fitness for i in summary.instances) / len(summary.instances)
    fresh = sum(i.fresh_mean for i in summary.instances) / len(summary.instances)
    print(f"{'mean':>10} {best:>8.3f} {fresh:>11.3f}")
    print(
        f"{summary.wall_seconds:.1f} s, {summary.env_steps_per_second:,.0f} env-steps/s, "
        f"useful slot-steps {summary.useful_share:.0%}, host {summary.host_share:.1%}",
        flush=True,
    )
