"""slcs2 evolve: one run, or a sweep of them advanced together."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from slcs2_jax.commands.advance import advance
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.door import check_below
from slcs2_jax.config.errors import InputError, refuse

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.compose import Job

TAKES_SETTINGS = True
OPTIONS = ()
HELP = """\
slcs2 evolve [setting=value ...]: evolve rule-sets in one world type; writes a run folder and shows progress on stderr

Choices: environment=open|jammed|urban|urban_jammed  range=short|long  grammar=main|channel|power|both|PATH
         search=slcs2|ailta|random|informed|starters, and those of your plug-ins: plugins=[my_module]
         (slcs2 parts lists all parts)
Options: -m, --multirun    settings may hold several values (environment=open,urban): one run for every combination,
                           each in a folder of its own below run_dir, advanced together
         --cfg job         print the composed configuration and stop
         --config-dir DIR  look for groups (DIR/radio/mine.yaml: radio=mine) there too
         --hydra-help      what of Hydra, which is underneath, works here: override syntax, launchers, sweepers
With a run_dir that holds the same run already, it goes on where it was interrupted, or further if more generations
are asked for (slcs2 resume does the same for whole folders).
Exit code: 0 done, 1 the disk refused, 2 bad input (one line says what), 130 or 143 interrupted.
"""


def run(arguments: list[str]) -> int:
    """Evolve what the arguments ask for."""
    line = CommandLine.parse(arguments)
    from slcs2_jax.config.compose import run_hydra
    from slcs2_jax.config.store import Primary
    from slcs2_jax.results.sweep import write_sweep

    primary = Primary(name="evolve")
    started = datetime.now()

    def validate(jobs: list[Job]) -> list[float]:
        write_sweep(_sweep_dir(jobs[0], started), _settings_of(jobs, started))
        return [0.0] * len(jobs)

    def together(jobs: list[Job]) -> list[float]:
        settings = _settings_of(jobs, started)
        if line.sweep:
            write_sweep(_sweep_dir(jobs[0], started), settings)
        summaries = advance(settings)
        # Hydra's optimising sweepers minimise
        return [-sum(i.best_fitness for i in summary.instances) / len(summary.instances) for summary in summaries]

    if line.sweep and line.names_launcher and not line.names_sweeper:
        # such a launcher starts each run by itself: look at all of them before it starts the first
        run_hydra(primary, line.without_launcher(), validate)
    run_hydra(primary, line, together)
    return 0


def _settings_of(jobs: Sequence[Job], started: datetime) -> list[Settings]:
    """Every job's settings with its run folder, all of them checked."""
    from slcs2_jax.config import settings_from
    from slcs2_jax.results import check_usable
    from slcs2_jax.results.loggers import check_logger
    from slcs2_jax.search.slcs2 import check_parts

    found: list[Settings] = []
    for job in jobs:
        settings = settings_from(job.config)
        settings = dataclasses.replace(settings, run_dir=_run_dir(settings, job, started))
        _check_grammar(settings)
        check_parts(settings.search)
        check_logger(settings)
        check_usable(settings)
        found.append(settings)
    folders = [settings.run_dir for settings in found]
    for folder in folders:
        if folders.count(folder) > 1:
            raise refuse("run_dir", folder, "a folder of its own for every run of a sweep")
    for settings in found:
        if settings.compute != found[0].compute:
            raise InputError("compute: differs between the runs of a sweep; accepted is one value for all of them")
    return found


def _run_dir(settings: Settings, job: Job, started: datetime) -> str:
    """The run folder: as given, or runs/DATE_TIME_...; in a sweep a folder below that for each combination."""
    if job.label:
        above = Path(_sweep_dir(job, started))
        check_below(above, above / job.label)
        return str(above / job.label)
    if settings.run_dir is not None:
        return settings.run_dir
    grammar = Path(settings.rules.grammar).stem
    world = settings.world
    return str(Path("runs") / f"{_stamp(started)}_{world.environment}_{world.range}_{grammar}_s{settings.seed}")


def _sweep_dir(job: Job, started: datetime) -> str:
    """The folder that holds the runs of a sweep."""
    given = job.config.get("run_dir")
    return str(Path("runs") / f"{_stamp(started)}_sweep") if given is None else str(given)


def _stamp(started: datetime) -> str:
    return started.strftime("%Y%m%d_%H%M%S")


def _check_grammar(settings: Settings) -> None:
    from slcs2_jax.grammar.grammar import Grammar

    Grammar.of(settings)
