"""What a run folder has to show: solutions, of a run under way those of its last checkpoint; and episodes of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import Checkpoint, Compute, InputError, Settings
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.door import present, telling_damage
from slcs2_jax.config.field import refuse, show
from slcs2_jax.grammar import Grammar, RuleSets
from slcs2_jax.looking.recording import Recording, record
from slcs2_jax.policy.bound import bind_list, bind_rules
from slcs2_jax.policy.decision_list import DecisionList
from slcs2_jax.results import FinishedRun, SavedSolution
from slcs2_jax.results.archive import read_archive
from slcs2_jax.results.files import storing
from slcs2_jax.results.run_config import read_config
from slcs2_jax.results.run_folder import CHECKPOINT, CHECKPOINT_FORMAT, checkpoint_limits, read_grammar
from slcs2_jax.search.evaluation import fresh_deployment_key
from slcs2_jax.search.member import Member
from slcs2_jax.search.packing import unpack_members
from slcs2_jax.world.scenario import make_scenario

MOST_DEPLOYMENTS = 10**6


def as_saved(member: Member, settings: Settings, grammar_text: str, seed: int) -> SavedSolution:
    """A member as it is written to a file, by the settings of its run and its instance's seed."""
    evaluation, solution = member.evaluation, member.solution
    return SavedSolution(
        rules=RuleSets(solution.mask, solution.action),
        quality=evaluation.quality,
        strength=evaluation.strength,
        error=evaluation.error,
        usage=np.rint(evaluation.usage).astype(np.int32),
        contribution=evaluation.contribution.astype(np.float32),
        # equal runs have equal bytes wherever they lie and whatever computed and saved them
        settings=dataclasses.replace(settings, run_dir=None, compute=Compute(), checkpoint=Checkpoint()),
        grammar_text=grammar_text,
        instance_seed=seed,
        generation=member.generation,
        fitness=member.fitness,
        deployments=evaluation.deployments,
        origin_kind=solution.origin_kind,
        origin_generation=solution.origin_generation,
        origin_agent=solution.origin_agent,
    )


def best_of(run: FinishedRun, instance: int) -> SavedSolution:
    """The best solution of an instance; of a run under way, the best when it was last saved.

    Raises InputError: no such instance, nothing saved yet, or a damaged file.
    """
    if run.summary is not None:
        return run.best(instance)
    best, _ = _saved_last(run, instance)
    if best is None:
        raise InputError(f"run={show(str(run.path))}: nothing was saved yet of instance {instance}; look again later")
    return best


def members_of(run: FinishedRun, instance: int) -> list[SavedSolution]:
    """The collection of an instance, the oldest member first; of a run under way, when it was last saved.

    Raises InputError: no such instance, or a damaged file.
    """
    return run.members(instance) if run.summary is not None else _saved_last(run, instance)[1]


def member_of(run: FinishedRun, instance: int, member: str) -> SavedSolution:
    """`best`, or a member of the collection by its number. Raises InputError if there is none such."""
    if member == "best":
        return best_of(run, instance)
    found = members_of(run, instance)
    if not (member.isascii() and member.isdecimal() and int(member) < len(found)):
        raise refuse("member", member, f"best, or a number from 0 to {len(found) - 1}" if found else "best")
    return found[int(member)]


def _saved_last(run: FinishedRun, instance: int) -> tuple[SavedSolution | None, list[SavedSolution]]:
    """Best solution and collection in the checkpoint of a run under way; None and none before the first save."""
    instance = whole("instance", instance, 0, run.settings.instances - 1)
    file = run.path / CHECKPOINT
    if not present(file):
        return None, []
    prefix, limits = f"{instance}.search.members.", checkpoint_limits(run.settings)
    try:
        with storing(file, "read"):
            arrays, about = read_archive(file, CHECKPOINT_FORMAT, limits, wanted=lambda name: name.startswith(prefix))
        grammar = read_grammar(run.path, read_config(run.path))
        with telling_damage():
            held = unpack_members({name.removeprefix(prefix): array for name, array in arrays.items()})
            search = about["instances"][instance]["search"]
            saved = [as_saved(one, run.settings, grammar, search["seed"]) for one in held]
            return None if search["best"] is None else saved[search["best"]], saved[: search["members"]]
    except InputError as error:
        raise InputError(f"{file}: {error}; slcs2 resume {run.path} says what can be done") from None


def replay(
    solution: SavedSolution,
    settings: Settings | None = None,
    *,
    seed: int | None = None,
    deployment: int = 0,
    after_chunk: Callable[[int], None] = lambda steps: None,
) -> Recording:
    """A fresh deployment of a solution, recorded.

    Args:
        solution: what is deployed.
        settings: those of the world; by default those it evolved with.
        seed: of the scenario; by default that of the instance it evolved in.
        deployment: which; the winner's fresh figures are means over the first `search.fresh_deployments` of these.
        after_chunk: told now and then how many steps were computed.

    Raises:
        InputError: an argument of another kind, or an impossible setting.
    """
    of_kind("solution", solution, SavedSolution)
    settings = of_kind("settings", settings, Settings) if settings is not None else solution.settings
    solution.check_fits(settings)
    grammar = Grammar.of(settings, solution.grammar_text)
    scenario = make_scenario(settings, solution.instance_seed if seed is None else seed)
    key = fresh_deployment_key(scenario.seed, whole("deployment", deployment, 0, MOST_DEPLOYMENTS))
    runtime.configure(settings.compute)
    return record(settings, scenario, bind_rules(solution.rules, grammar), key, after_chunk=after_chunk)


def replay_list(
    decisions: DecisionList,
    settings: Settings,
    *,
    seed: int,
    deployment: int = 0,
    after_chunk: Callable[[int], None] = lambda steps: None,
) -> Recording:
    """A deployment of a decision list, recorded; arguments as `replay` has them."""
    scenario = make_scenario(settings, seed)
    key = fresh_deployment_key(scenario.seed, whole("deployment", deployment, 0, MOST_DEPLOYMENTS))
    runtime.configure(settings.compute)
    return record(settings, scenario, bind_list(decisions, settings.swarm.agents), key, after_chunk=after_chunk)
