"""slcs2 experiment: the paper's experiments, those on searches and the calibration study, each by one command."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.advance import finish
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.compose import Job
    from slcs2_jax.config.store import Primary
    from slcs2_jax.study.calibrate import Task
    from slcs2_jax.study.experiment import Planned

TAKES_SETTINGS = True
OPTIONS = ("arm",)
HELP = """\
slcs2 experiment NAME [setting=value ...]: an experiment in the paper's eight cells, then the report on it

  contributions     full, without novelty search (AILTA instead), without rule exchange; 10 instances for each cell
  designed          evolved behaviours against the designed one; 30 instances for each cell
  grammars          main grammar, channel, power, both; 30 instances for each cell
  control           the paper's search and random search, each with search.episodes=200 deployments; 10 instances
  searches          informed, random and no search with the same knowledge, slcs2, each with search.episodes=150
                    deployments; the designed behaviour
  ablation          the informed search with each of its parts left out, for as many deployments
  calibration       how results move with each assumed value, and how well they fit the paper's figures
Sizes:   instances=N generations=N   the paper's by default
         environment=open,urban      some of open, jammed, urban, urban_jammed; range=short or range=long likewise
         arm=NAME                    one arm of the experiment alone
         run_dir=ROOT                runs/experiments; a run goes to ROOT/ARM/CELL/seed_000, the report to ROOT/report
What ROOT holds already is not computed again: repeated, the command goes on where it was interrupted; with more
instances or generations it adds what is missing; experiments in one ROOT share the runs that they have in common.
Everything advances in one process; hydra/launcher=joblib, submitit_slurm or ray makes a job of each cell
(docs/cluster.md).
Exit code: 0 done, 2 bad input (one line says what), 130 interrupted.
"""
ROOT = "runs/experiments"  # of all experiments, so that they find each other's runs
JOBS = "jobs"  # folder below the experiment's
_NODE = ("name", "title", "arms", "apart")
_OWN = ("experiment", "calibration", "arm", "run_dir")  # in the configuration, and no settings of a run


def run(arguments: list[str]) -> int:
    """Run what the arguments ask for, then report on its folder."""
    from slcs2_jax.config.compose import run_hydra
    from slcs2_jax.config.conf import groups, options

    name, *rest = arguments or [""]
    line = CommandLine.parse(rest)
    names = sorted({*groups()["experiment"], *(options(line.config_dir / "experiment") if line.config_dir else ())})
    if name not in names:
        raise refuse("experiment", name, "one of " + ", ".join(names) + " (slcs2 experiment --help)")
    primary, line = _primary(name), _over_all_cells(line)
    all_jobs: list[Job] = []

    def look(jobs: list[Job]) -> list[float]:
        for job in jobs:
            _look_at(job)
        all_jobs[:] = jobs
        return [0.0] * len(jobs)

    def together(jobs: list[Job]) -> list[float]:
        look(jobs)
        if name == "calibration":
            from slcs2_jax.study.calibrate import calibrate

            calibrate([_task(job) for job in jobs])
        else:
            _run([one for job in jobs for one in _planned(job)])
        return [0.0] * len(jobs)

    if line.show or line.hydra_help:
        run_hydra(primary, line, together)
        return 0
    if line.names_launcher:  # such a launcher starts each cell by itself: look at all of them before the first
        run_hydra(primary, line.without_launcher(), look)
    run_hydra(primary, line, together)
    _conclude(name, all_jobs)
    return 0


def _primary(name: str) -> Primary:
    """What the experiment's settings are composed from: the experiment has the last word but for the command line."""
    from slcs2_jax.config import Settings
    from slcs2_jax.config.store import Primary

    return Primary(
        name="experiment",
        settings=Settings(instances=30, run_dir=ROOT),
        own={"arm": "all"},
        open=("experiment", "calibration"),
        last=("experiment", name),
    )


def _over_all_cells(line: CommandLine) -> CommandLine:
    """A sweep over all cells, or those that are named."""
    from slcs2_jax.config.model import ENVIRONMENTS, RANGES

    if line.sets("experiment"):
        raise InputError("experiment: given twice; accepted is slcs2 experiment NAME")
    if line.show or line.hydra_help:
        return line
    cells = {"environment": ENVIRONMENTS, "range": RANGES}
    every = [f"{key}={','.join(options)}" for key, options in cells.items() if not line.sets(key)]
    if line.names_launcher and not line.sets("hydra.sweep.dir"):
        # what such a launcher writes (jobs, logs) belongs where all the machines of a cluster can see it
        every += [f"hydra.sweep.dir='${{run_dir}}/{JOBS}'", "hydra.sweep.subdir=."]
    return dataclasses.replace(line, sweep=True, overrides=(*every, *line.overrides))


def split(job: Job) -> tuple[dict[str, Any], dict[str, Any]]:
    """A run's settings, and what is the experiment's own."""
    own = {key: job.config[key] for key in _OWN if key in job.config}
    return {key: value for key, value in job.config.items() if key not in own}, own


def _task(job: Job) -> Task:
    from slcs2_jax.study.calibrate import Task

    config, own = split(job)
    return Task(config, own["calibration"], str(own["run_dir"]))


def _look_at(job: Job) -> None:
    """Check everything about a job that can be checked before anything is computed."""
    from slcs2_jax.commands.deployed import check_deployable
    from slcs2_jax.grammar.grammar import Grammar
    from slcs2_jax.results import check_usable
    from slcs2_jax.results.loggers import check_logger
    from slcs2_jax.search.slcs2 import check_parts

    if "calibration" in job.config:
        _ = _task(job).points
        return
    for one in _planned(job):
        if one.policy is not None:
            check_deployable(one)
            continue
        Grammar.of(one.settings)
        check_parts(one.settings.search)
        check_logger(one.settings)
        check_usable(one.settings)


def _planned(job: Job) -> list[Planned]:
    from slcs2_jax.study.experiment import Experiment, plan

    config, own = split(job)
    unknown = sorted(set(own["experiment"]) - set(_NODE))
    if unknown:
        raise refuse("setting", f"experiment.{unknown[0]}", "one of experiment." + ", experiment.".join(_NODE))
    experiment = Experiment.of(own["experiment"])
    runs = plan(str(own["run_dir"]), config, experiment, experiment.chosen(str(own["arm"])))
    return [one if one.policy is not None else dataclasses.replace(one, settings=_begun(one.settings)) for one in runs]


def _begun(settings: Settings) -> Settings:
    """A run that was begun with more generations keeps them: its first ones are those that are asked for."""
    from slcs2_jax.config.door import present
    from slcs2_jax.results.run_config import CONFIG, read_config

    folder = Path(str(settings.run_dir))
    if not present(folder / CONFIG):
        return settings
    begun = read_config(folder).settings.search.generations
    if begun <= settings.search.generations:
        return settings
    return dataclasses.replace(settings, search=dataclasses.replace(settings.search, generations=begun))


def _run(planned: Sequence[Planned]) -> None:
    """Make all runs, in one batch where they can share one."""
    from slcs2_jax.commands.deployed import deploy

    deploy([one for one in planned if one.policy is not None])
    evolved = [one.settings for one in planned if one.policy is None]
    if evolved:
        finish(evolved)


def _conclude(name: str, jobs: Sequence[Job]) -> None:
    """What the folder holds now, all of it: other experiments' runs too."""
    if name != "calibration":
        from slcs2_jax.commands.report import report_on

        report_on(str(jobs[0].config["run_dir"]))
        return
    from slcs2_jax.study.calibrate import conclude

    found = conclude([_task(job) for job in jobs])
    if not found.drawn:
        print("no figure: it needs matplotlib, the extra plot")
    for fit in found.fits[:5]:
        misfit = "unknown" if fit.misfit is None else f"{fit.misfit:.3f}"
        print(f"misfit {misfit}  {fit.point.kind:7}  {fit.point.name}")
    print(f"table {terminal(str(found.table))}", flush=True)
