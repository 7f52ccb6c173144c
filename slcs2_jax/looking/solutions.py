"""What a run folder has to show: solutions, of a run under way those of its last checkpoint; and episodes of them."""

from __future__ import annotations

from collections.abc import Callable

from slcs2_jax import runtime
from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.field import refuse, show
from slcs2_jax.config.worlds import home_of
from slcs2_jax.looking.recorder import record
from slcs2_jax.looking.recording import Recording
from slcs2_jax.results import FinishedRun, SavedSolution
from slcs2_jax.running.deployable import Deployable, bound
from slcs2_jax.running.evaluator import MOST_DEPLOYMENTS
from slcs2_jax.running.solutions import saved_last
from slcs2_jax.search.keys import fresh_deployment_key
from slcs2_jax.world.scenario import make_scenario


def best_of(run: FinishedRun, instance: int) -> SavedSolution:
    """The best solution of an instance; of a run under way, the best when it was last saved.

    Raises InputError: no such instance, nothing saved yet, or a damaged file.
    """
    if run.summary is not None:
        return run.best(instance)
    best, _ = saved_last(run, instance)
    if best is None:
        raise InputError(f"run={show(str(run.path))}: nothing was saved yet of instance {instance}; look again later")
    return best


def members_of(run: FinishedRun, instance: int) -> list[SavedSolution]:
    """The collection of an instance, the oldest member first; of a run under way, when it was last saved.

    Raises InputError: no such instance, or a damaged file.
    """
    return run.members(instance) if run.summary is not None else saved_last(run, instance)[1]


def member_of(run: FinishedRun, instance: int, member: str) -> SavedSolution:
    """`best`, or a member of the collection by its number. Raises InputError if there is none such."""
    if member == "best":
        return best_of(run, instance)
    found = members_of(run, instance)
    if not (member.isascii() and member.isdecimal() and int(member) < len(found)):
        raise refuse("member", member, f"best, or a number from 0 to {len(found) - 1}" if found else "best")
    return found[int(member)]


def replay(
    policy: Deployable,
    settings: Settings | None = None,
    *,
    seed: int | None = None,
    deployment: int = 0,
    steps: int | None = None,
    after_chunk: Callable[[int], None] = lambda steps: None,
) -> Recording:
    """A fresh deployment of a policy, recorded.

    Args:
        policy: what is deployed: a saved solution, or whatever else `deploy` takes.
        settings: those of the world; by default those that a saved solution evolved with.
        seed: of the scenario; by default that of the instance that a saved solution evolved in, else that of the
            settings. Of settings with many worlds it is that of the search, and the deployment's world is shown.
        deployment: which; the winner's fresh figures are means over the first `search.fresh_deployments` of these.
        steps: how many are needed of the episode; None: all.
        after_chunk: told now and then how many steps were computed.

    Raises:
        InputError: an argument of another kind, or an impossible setting.
    """
    if settings is None:
        settings = of_kind("solution", policy, SavedSolution).settings
    settings = of_kind("settings", settings, Settings)
    ready = bound(policy, settings)
    if seed is None:
        seed = policy.instance_seed if isinstance(policy, SavedSolution) else settings.seed
    deployment = whole("deployment", deployment, 0, MOST_DEPLOYMENTS)
    key = fresh_deployment_key(seed, deployment)
    settings, seed = home_of(settings, seed, deployment)
    scenario = make_scenario(settings, seed)
    runtime.configure(settings.compute)
    return record(settings, scenario, ready, key, steps=steps, after_chunk=after_chunk)
