"""The console command slcs2: parse, validate, call, print. No science here, no JAX before all is validated."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.compose import Job
    from slcs2_jax.results import EvaluationSummary, RunSummary

USAGE = """\
slcs2: evolve and evaluate the behaviour of swarms (SLCS2, arXiv 1910.12412)

  slcs2 evolve [setting=value ...]                      one run of several instances
  slcs2 evolve -m [setting=value,value,... ...]         one run for every combination, all in one batch
  slcs2 evaluate solution=PATH [setting=value ...]      a saved solution on any scenarios
  slcs2 --version
  slcs2 [evolve|evaluate] --help

Examples:
  slcs2 evolve environment=urban range=short seed=0 instances=8 generations=500 grammar=main
  slcs2 evolve -m environment=open,jammed,urban,urban_jammed range=short,long
  slcs2 evolve acceptance=ailta exchange=off radio.path_loss_exponent=3.0 run_dir=results/ablation
  slcs2 evaluate solution=RUN/solutions/instance_000_best.npz environment=urban range=long instances=30
"""

EVOLVE_HELP = """\
slcs2 evolve [setting=value ...]: evolve rule-sets in one world type; writes a run folder and shows progress on stderr

Choices: environment=open|jammed|urban|urban_jammed  range=short|long  grammar=main|channel|power|both|PATH
Options: -m, --multirun    settings may hold several values (environment=open,urban): one run for every combination,
                           each in a folder of its own below run_dir, advanced together
         --cfg job         print the composed configuration and stop
         --config-dir DIR  look for groups (DIR/radio/mine.yaml: radio=mine) there too
Hydra is underneath: its override syntax, sweeps and hydra/launcher=... work here.
Exit code: 0 done, 2 bad input (one line says what), 130 interrupted.
"""

EVALUATE_HELP = """\
slcs2 evaluate solution=PATH [setting=value ...]: deploy a saved solution in fresh scenarios and print its fitness

  solution=PATH     RUN/solutions/instance_000_best.npz
  deployments=1     episodes in each scenario; whole number >= 1
  instances=30      scenarios; scenario i has seed + i
What is not given is as it was when the solution evolved; agents, rules and grammar are the solution's own.
With run_dir=PATH the summary is written there too.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        return _dispatch(arguments)
    except InputError as error:
        return _fail(str(error), 2)
    except KeyboardInterrupt:
        return _fail("interrupted; what was finished is in the run folder", 130)
    except BrokenPipeError:  # whoever read our output went away
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _fail(message: str, code: int) -> int:
    line = " ".join(message.split())
    print(f"slcs2: error: {line}" if code == 2 else f"slcs2: {line}", file=sys.stderr, flush=True)
    return code


def _dispatch(arguments: list[str]) -> int:
    commands: dict[str, Callable[[list[str]], int]] = {"evolve": _evolve, "evaluate": _evaluate}
    if arguments and arguments[0] == "--version":
        from slcs2_jax import __version__

        print(f"slcs2 {__version__}")
        return 0
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        return _help(USAGE)
    command, *rest = arguments
    if command not in commands:
        raise refuse("command", command, "one of " + ", ".join(commands) + " (slcs2 --help)")
    if "-h" in rest or "--help" in rest:
        return _help(EVOLVE_HELP if command == "evolve" else EVALUATE_HELP)
    _check_flags(rest)
    return commands[command](rest)


def _help(text: str) -> int:
    from slcs2_jax.config.table import settings_help

    print(text)
    print(settings_help(), end="", flush=True)
    return 0


def _check_flags(arguments: Sequence[str]) -> None:
    """Refuse in one line what Hydra's parser would refuse in many."""
    from slcs2_jax.config.compose import CFG_VALUES, FLAGS, FLAGS_WITH_VALUE, is_sweep

    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        if argument in FLAGS_WITH_VALUE:
            if not rest or rest[0].startswith("-"):
                raise InputError(f"option {argument}: accepted is {argument} VALUE")
            value = rest.pop(0)
            if argument in ("-c", "--cfg"):
                if value not in CFG_VALUES:
                    raise refuse(f"option {argument}", value, "one of " + ", ".join(CFG_VALUES))
                if is_sweep(arguments):
                    raise InputError(f"option {argument}: not together with -m; accepted is one of the two")
        elif argument.startswith("-") and argument not in FLAGS:
            raise refuse("option", argument, "one of -m, --cfg job, --config-dir DIR, --help")


# -- evolve ------------------------------------------------------------------------------------------------------------


def _evolve(arguments: list[str]) -> int:
    from slcs2_jax.config.compose import is_sweep, names_launcher, names_sweeper, run_hydra, without_launcher

    started = datetime.now()

    def validate(jobs: list[Job]) -> list[float]:
        _settings_of(jobs, started)
        return [0.0] * len(jobs)

    def together(jobs: list[Job]) -> list[float]:
        summaries = _run(_settings_of(jobs, started))
        # Hydra's optimising sweepers minimise
        return [-sum(i.best_fitness for i in summary.instances) / len(summary.instances) for summary in summaries]

    if is_sweep(arguments) and names_launcher(arguments) and not names_sweeper(arguments):
        # such a launcher starts each run by itself: look at all of them before it starts the first
        run_hydra("evolve", without_launcher(arguments), validate)
    run_hydra("evolve", arguments, together)
    return 0


def _settings_of(jobs: Sequence[Job], started: datetime) -> list[Settings]:
    """Every job's settings with its run folder, all of them checked."""
    from slcs2_jax.config import settings_from
    from slcs2_jax.results.run_folder import check_free

    found: list[Settings] = []
    for job in jobs:
        settings = settings_from(job.config)
        settings = dataclasses.replace(settings, run_dir=_run_dir(settings, job, started))
        _check_grammar(settings)
        assert settings.run_dir is not None
        check_free(settings.run_dir)
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
    stamp = started.strftime("%Y%m%d_%H%M%S")
    if settings.run_dir is not None:
        return str(Path(settings.run_dir) / job.label) if job.label else settings.run_dir
    if job.label:
        return str(Path("runs") / f"{stamp}_sweep" / job.label)
    grammar = Path(settings.rules.grammar).stem
    name = f"{stamp}_{settings.world.environment}_{settings.world.range}_{grammar}_s{settings.seed}"
    return str(Path("runs") / name)


def _check_grammar(settings: Settings) -> None:
    from slcs2_jax.grammar import load_grammar

    rules = settings.rules
    load_grammar(rules.grammar, max_clauses=rules.max_clauses, single_option_consumes=rules.single_option_consumes)


def _run(settings: list[Settings]) -> list[RunSummary]:
    from slcs2_jax import runtime
    from slcs2_jax.results import Progress

    runtime.configure(settings[0].compute)
    from slcs2_jax.evolution import driver

    total = max(run.search.generations for run in settings)
    with Progress(total) as report:
        summaries: list[RunSummary] = driver.evolve(settings, report=report)
    for summary in summaries:
        _print_run(summary)
    return summaries


def _print_run(summary: RunSummary) -> None:
    print(f"run folder {summary.run_dir}")
    print(f"{'seed':>10} {'best':>8} {'fresh mean':>11} {'fresh sd':>9} {'evaluations':>12} {'env-steps':>14}")
    for i in summary.instances:
        print(
            f"{i.seed:>10} {i.best_fitness:>8.3f} {i.fresh_mean:>11.3f} {i.fresh_sd:>9.3f} "
            f"{i.evaluations:>12,} {i.env_steps:>14,}"
        )
    best = sum(i.best_fitness for i in summary.instances) / len(summary.instances)
    fresh = sum(i.fresh_mean for i in summary.instances) / len(summary.instances)
    print(f"{'mean':>10} {best:>8.3f} {fresh:>11.3f}")
    print(f"{summary.wall_seconds:.1f} s, {summary.env_steps_per_second:,.0f} env-steps/s", flush=True)


# -- evaluate ----------------------------------------------------------------------------------------------------------


def _evaluate(arguments: list[str]) -> int:
    from slcs2_jax.config.compose import is_sweep, run_hydra

    if is_sweep(arguments):
        raise InputError("option -m: not for evaluate; accepted is one value for each setting")
    if not any(argument.startswith("solution=") for argument in arguments):
        raise InputError("solution: has no default; accepted is solution=PATH of a file RUN/solutions/*.npz")

    def together(jobs: list[Job]) -> list[float]:
        return [_evaluate_job(job) for job in jobs]

    run_hydra("evaluate", arguments, together)
    return 0


def _evaluate_job(job: Job) -> float:
    from slcs2_jax import runtime
    from slcs2_jax.config.overlay import evaluation_settings, take
    from slcs2_jax.results import Progress, RunFolder, load_solution
    from slcs2_jax.results.run_folder import check_free

    config, own = take(job.config, "solution", "deployments")
    solution = load_solution(str(own["solution"]))
    deployments = _whole_number("deployments", own["deployments"])
    settings = evaluation_settings(solution.settings, config, job.overrides)
    if settings.run_dir is not None:
        check_free(settings.run_dir)
    runtime.configure(settings.compute)
    from slcs2_jax.evolution import driver

    folder = None
    if settings.run_dir is not None:
        record = {"solution": str(own["solution"]), "deployments": deployments}
        folder = RunFolder.create(settings, device=runtime.describe_devices(settings.compute), record=record)
    with Progress(deployments, label="deployment") as report:
        summary: EvaluationSummary = driver.evaluate(settings, solution, deployments=deployments, report=report)
    if folder is not None:
        folder.write_summary(summary.to_json())
    _print_evaluation(summary, settings)
    return -summary.mean


def _whole_number(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 10**6:
        raise refuse(name, value, "a whole number from 1 to 1000000")
    return value


def _print_evaluation(summary: EvaluationSummary, settings: Settings) -> None:
    print(f"{settings.world.environment} {settings.world.range}, {len(summary.scenarios)} scenarios")
    print(f"{'seed':>10} {'fitness':>8} {'sd':>7} {'delivered':>10} {'steps':>9}")
    for s in summary.scenarios:
        print(f"{s.seed:>10} {s.fitness:>8.3f} {s.fitness_sd:>7.3f} {s.delivered:>10.1f} {s.steps:>9.1f}")
    print(f"{'mean':>10} {summary.mean:>8.3f} {summary.sd:>7.3f}")
    print(f"{summary.wall_seconds:.1f} s, {summary.env_steps_per_second:,.0f} env-steps/s", flush=True)
