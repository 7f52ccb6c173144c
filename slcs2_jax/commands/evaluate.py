"""slcs2 evaluate: a saved solution, or a behaviour made by hand, in fresh scenarios."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from slcs2_jax.commands.options import check_options
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.compose import Job
    from slcs2_jax.results import EvaluationSummary, Report

TAKES_SETTINGS = True
HELP = """\
slcs2 evaluate solution=PATH [setting=value ...]: deploy a saved solution in fresh scenarios and print its fitness
slcs2 evaluate controller=NAME [setting=value ...]: deploy a behaviour made by hand, the same in every agent

  solution=PATH     RUN/solutions/instance_000_best.npz
  controller=NAME   designed, or the path of a text: one rule a line, the first that holds acts (docs/designed.md)
  deployments=1     episodes in each scenario; whole number >= 1
  instances=30      scenarios; scenario i has seed + i
What is not given is as it was when the solution evolved; agents, rules and grammar are the solution's own. With a
controller it is as slcs2 evolve has it. With run_dir=PATH the summary is written there too.
"""


def run(arguments: list[str]) -> int:
    """Evaluate what the arguments ask for."""
    check_options(arguments)
    from slcs2_jax.config.compose import is_sweep, run_hydra

    if is_sweep(arguments):
        raise InputError("option -m: not for evaluate; accepted is one value for each setting")
    given = [name for name in ("solution", "controller") if any(a.startswith(f"{name}=") for a in arguments)]
    if not given:
        raise InputError(
            "solution: has no default; accepted is solution=PATH of a file RUN/solutions/*.npz, or controller=NAME"
        )
    if len(given) > 1:
        raise InputError("solution: not together with controller; accepted is one of the two")

    def together(jobs: list[Job]) -> list[float]:
        return [_evaluate_job(job) for job in jobs]

    run_hydra("evaluate", arguments, together)
    return 0


def _evaluate_job(job: Job) -> float:
    from slcs2_jax import runtime
    from slcs2_jax.config.overlay import take
    from slcs2_jax.results import Progress, RunFolder
    from slcs2_jax.results.run_folder import check_free

    config, own = take(job.config, "solution", "controller", "deployments")
    deployments = _whole_number("deployments", own["deployments"])
    what = _behaviour(config, own["controller"]) if own["controller"] is not None else _solution(config, own, job)
    settings = what.settings
    if settings.run_dir is not None:
        check_free(settings.run_dir)
    runtime.configure(settings.compute)
    with Progress(deployments, label="deployment") as report:
        summary = what.evaluate(deployments, report)
    if settings.run_dir is not None:  # made only now: an interrupted evaluation leaves nothing behind
        record = {**what.record, "deployments": deployments}
        folder = RunFolder.create(settings, device=runtime.describe_devices(settings.compute), record=record)
        folder.write_timing(summary.timing())
        folder.write_summary(summary.to_json())
    _print_evaluation(summary, settings)
    return -summary.mean


class _What(NamedTuple):
    """What is evaluated: its settings, what the run folder records of it, and how it is done."""

    settings: Settings
    record: dict[str, Any]
    evaluate: Callable[[int, Report], EvaluationSummary]


def _solution(config: dict[str, Any], own: dict[str, Any], job: Job) -> _What:
    from slcs2_jax.config.overlay import evaluation_settings
    from slcs2_jax.results import load_solution

    solution = load_solution(str(own["solution"]))
    settings = evaluation_settings(solution.settings, config, job.overrides)

    def evaluate(deployments: int, report: Report) -> EvaluationSummary:
        from slcs2_jax.running import driver

        return driver.evaluate(settings, solution, deployments=deployments, report=report)

    return _What(settings, {"solution": str(own["solution"])}, evaluate)


def _behaviour(config: dict[str, Any], controller: Any) -> _What:
    from slcs2_jax.commands.deployed import BEHAVIOUR
    from slcs2_jax.config import settings_from
    from slcs2_jax.policy.decision_list import load_decision_list
    from slcs2_jax.study.collect import CONTROLLER

    behaviour = load_decision_list(str(controller))
    settings = settings_from(config)

    def evaluate(deployments: int, report: Report) -> EvaluationSummary:
        from slcs2_jax.running import driver

        return driver.evaluate_list(settings, behaviour, deployments=deployments, report=report)

    return _What(settings, {CONTROLLER: behaviour.name, BEHAVIOUR: behaviour.text}, evaluate)


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
