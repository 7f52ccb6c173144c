"""slcs2 experiment: the paper's experiments and the calibration study, each by one command."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.advance import finish
from slcs2_jax.commands.options import check_options
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.compose import Job
    from slcs2_jax.study.experiment import Planned

TAKES_SETTINGS = True
HELP = """\
slcs2 experiment NAME [setting=value ...]: an experiment of the paper in its eight cells, then the report on it

  contributions     full, without novelty search (AILTA instead), without rule exchange; 10 instances for each cell
  designed          evolved behaviours against the designed one; 30 instances for each cell
  grammars          main grammar, channel, power, both; 30 instances for each cell
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
JOBS = "jobs"  # folder below the experiment's
_OWN = ("experiment", "calibration", "arm", "run_dir")  # in the configuration, and no settings of a run


def run(arguments: list[str]) -> int:
    """Run what the arguments ask for, then report on its folder."""
    from slcs2_jax.config.compose import groups, names_launcher, run_hydra, without_launcher

    name, *rest = arguments or [""]
    names = sorted({*groups()["experiment"], *_own_experiments(rest)})
    if name not in names:
        raise refuse("experiment", name, "one of " + ", ".join(names) + " (slcs2 experiment --help)")
    check_options(rest)
    composed = _arguments(name, rest)
    all_jobs: list[Job] = []

    def look(jobs: list[Job]) -> list[float]:
        for job in jobs:
            _look_at(job)
        all_jobs[:] = jobs
        return [0.0] * len(jobs)

    def together(jobs: list[Job]) -> list[float]:
        look(jobs)
        if name == "calibration":
            from slcs2_jax.commands.calibration import calibrate

            calibrate([split(job) for job in jobs])
        else:
            _run([one for job in jobs for one in _planned(job)])
        return [0.0] * len(jobs)

    if "--cfg" in rest or "-c" in rest:
        run_hydra("experiments", composed, together)
        return 0
    if names_launcher(rest):  # such a launcher starts each cell by itself: look at all of them before the first
        here = [argument for argument in without_launcher(composed) if not argument.startswith("hydra.sweep.")]
        run_hydra("experiments", here, look)
    run_hydra("experiments", composed, together)
    _conclude(name, all_jobs)
    return 0


def _own_experiments(rest: Sequence[str]) -> list[str]:
    """Names of the user's experiments, in the folder of --config-dir."""
    folders = [Path(value) for option, value in itertools.pairwise(rest) if option in ("-cd", "--config-dir")]
    return [file.stem for folder in folders for file in (folder / "experiment").glob("*.yaml")]


def _arguments(name: str, rest: Sequence[str]) -> list[str]:
    """What Hydra is asked for: a sweep over all cells, or those that are named."""
    from slcs2_jax.config.compose import names_launcher
    from slcs2_jax.config.model import ENVIRONMENTS, RANGES

    if any(argument.startswith("experiment=") for argument in rest):
        raise InputError("experiment: given twice; accepted is slcs2 experiment NAME")
    if "--cfg" in rest or "-c" in rest:
        return [f"experiment={name}", *rest]
    cells = {"environment": ENVIRONMENTS, "range": RANGES}
    every = [
        f"{key}={','.join(options)}"
        for key, options in cells.items()
        if not any(argument.startswith(f"{key}=") for argument in rest)
    ]
    if names_launcher(rest) and not any(argument.startswith("hydra.sweep.dir=") for argument in rest):
        # what such a launcher writes (jobs, logs) belongs where all the machines of a cluster can see it
        every += [f"hydra.sweep.dir='${{run_dir}}/{JOBS}'", "hydra.sweep.subdir=."]
    return ["-m", f"experiment={name}", *every, *(a for a in rest if a not in ("-m", "--multirun"))]


def split(job: Job) -> tuple[dict[str, Any], dict[str, Any]]:
    """A run's settings, and what is the experiment's own."""
    own = {key: job.config[key] for key in _OWN if key in job.config}
    return {key: value for key, value in job.config.items() if key not in own}, own


def _look_at(job: Job) -> None:
    """Check everything about a job that can be checked before anything is computed."""
    from slcs2_jax.commands.deployed import check_deployable
    from slcs2_jax.grammar import load_grammar
    from slcs2_jax.results import check_usable

    config, own = split(job)
    if "calibration" in own:
        from slcs2_jax.commands.calibration import tried

        tried(config, own["calibration"])
        return
    for one in _planned(job):
        if one.controller is not None:
            check_deployable(one)
            continue
        rules = one.settings.rules
        load_grammar(rules.grammar, max_clauses=rules.max_clauses, single_option_consumes=rules.single_option_consumes)
        check_usable(one.settings)


def _planned(job: Job) -> list[Planned]:
    from slcs2_jax.study.experiment import Experiment, plan

    config, own = split(job)
    experiment = Experiment.of(own["experiment"])
    runs = plan(str(own["run_dir"]), config, experiment, experiment.chosen(str(own["arm"])))
    return [
        one if one.controller is not None else dataclasses.replace(one, settings=_begun(one.settings)) for one in runs
    ]


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

    deploy([one for one in planned if one.controller is not None])
    evolved = [one.settings for one in planned if one.controller is None]
    if evolved:
        finish(evolved)


def _conclude(name: str, jobs: Sequence[Job]) -> None:
    """What the folder holds now, all of it: other experiments' runs too."""
    root = str(jobs[0].config["run_dir"])
    if name == "calibration":
        from slcs2_jax.commands.calibration import conclude

        conclude(root, [split(job) for job in jobs])
    else:
        from slcs2_jax.commands.report import report_on

        report_on(root)
