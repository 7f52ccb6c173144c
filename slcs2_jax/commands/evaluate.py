"""slcs2 evaluate: a saved solution, or another policy, in fresh scenarios."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.policies import policy_named
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.errors import InputError, refuse

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.compose import Job
    from slcs2_jax.results import EvaluationSummary, SavedSolution
    from slcs2_jax.running.deployable import Deployable

TAKES_SETTINGS = True
HELP = """\
slcs2 evaluate solution=PATH [setting=value ...]: deploy a saved solution in fresh scenarios and print its fitness
slcs2 evaluate swarm=NAME [setting=value ...]: an evolved swarm that comes with slcs2, such as long_urban
slcs2 evaluate policy=NAME [setting=value ...]: deploy another policy, the same in every agent

  solution=PATH     RUN/solutions/instance_000_best.npz
  policy=NAME       designed; the path of a text: one rule a line, the first that holds acts (docs/designed.md); a
                    policy's file .npz; or a name that plugins= brings
  deployments=1     episodes in each scenario; whole number >= 1
  instances=30      scenarios; scenario i has seed + i
  quality=kept      forgotten: the solution's rules begin with the quality of learning.initial_quality, not with what
                    they inherited (search.inherit_quality)
What is not given is as it was when the solution evolved; agents, rules and grammar are the solution's own. With a
policy it is as slcs2 evolve has it. With run_dir=PATH the summary is written there too.
"""
_OWN: dict[str, Any] = {"solution": None, "policy": None, "deployments": 1, "quality": "kept"}
OPTIONS = tuple(_OWN)


def run(arguments: list[str]) -> int:
    """Evaluate what the arguments ask for."""
    line = CommandLine.parse(arguments)
    if line.sweep:
        raise InputError("option -m: not for evaluate; accepted is one value for each setting")
    from slcs2_jax.config.compose import run_hydra
    from slcs2_jax.config.overlay import deployment_primary
    from slcs2_jax.config.overrides import text_of
    from slcs2_jax.results import load_solution
    from slcs2_jax.results.swarms import swarm_file

    path, swarm, policy = (text_of(line.overrides, name) for name in ("solution", "swarm", "policy"))
    # not the node of the settings swarm.*, which Hydra would take it for
    line = dataclasses.replace(line, overrides=tuple(one for one in line.overrides if not one.startswith("swarm=")))
    if not (path or swarm or policy or line.show or line.hydra_help):
        raise InputError(
            "solution: has no default; accepted is solution=PATH of a file RUN/solutions/*.npz, swarm=NAME, or "
            "policy=NAME"
        )
    if sum(given is not None for given in (path, swarm, policy)) > 1:
        raise InputError("solution: not together with swarm or policy; accepted is one of them")
    solution = load_solution(path or swarm_file(str(swarm))) if path or swarm else None

    def together(jobs: list[Job]) -> list[float]:
        return [_evaluate_job(job, solution, swarm) for job in jobs]

    evolved = None if solution is None else solution.settings
    run_hydra(deployment_primary("evaluate", evolved, own=_OWN, instances=30), line, together)
    return 0


def _evaluate_job(job: Job, solution: SavedSolution | None, swarm: str | None) -> float:
    from slcs2_jax import runtime
    from slcs2_jax.config.overlay import deployment_settings, take
    from slcs2_jax.native.choice import computed_on
    from slcs2_jax.results import Progress, RunFolder
    from slcs2_jax.results.run_folder import check_free

    config, own = take(job.config, *_OWN)
    deployments = _whole_number("deployments", own["deployments"])
    settings = deployment_settings(config, None if solution is None else solution.settings)
    policy, of_policy = _policy(own, solution, swarm)
    if settings.run_dir is not None:
        check_free(settings.run_dir)
    runtime.configure(settings.compute)
    with Progress(deployments, label="deployment") as report:
        from slcs2_jax.running import driver

        summary = driver.evaluate(settings, policy, deployments=deployments, report=report)
    if settings.run_dir is not None:  # made only now: an interrupted evaluation leaves nothing behind
        record = {**of_policy, "deployments": deployments}
        folder = RunFolder.create(settings, device=computed_on(settings.compute), record=record)
        folder.write_timing(summary.timing())
        folder.write_summary(summary.to_json())
    _print_evaluation(summary, settings)
    return -summary.mean


def _policy(
    own: dict[str, Any], solution: SavedSolution | None, swarm: str | None
) -> tuple[Deployable, dict[str, Any]]:
    """What is evaluated, and what the run folder records of it."""
    kept = own["quality"]
    if kept not in ("kept", "forgotten"):
        raise refuse("quality", kept, "one of kept, forgotten")
    if solution is not None:
        record = {"swarm": swarm} if swarm else {"solution": str(own["solution"])}
        return (solution, record) if kept == "kept" else (solution.forgetful(), record | {"quality": kept})
    from slcs2_jax.commands.deployed import BEHAVIOUR
    from slcs2_jax.study.collect import POLICY

    named = policy_named(str(own["policy"]))
    return named.policy, {POLICY: str(own["policy"]), BEHAVIOUR: named.content}


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
