"""A decision list in many worlds at once: runs that can share a device batch share it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from slcs2_jax.config import Settings
from slcs2_jax.policy.decision_list import DecisionList
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.results import Quiet, Report
from slcs2_jax.running.batches import make_batches
from slcs2_jax.running.driver import batch_key
from slcs2_jax.running.instance import Measurement, Site
from slcs2_jax.running.schedule import play
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.swarm.task import task_of
from slcs2_jax.world.scenario import make_scenario


def deploy_list(
    settings: Sequence[Settings], decisions: DecisionList, *, deployments: int, report: Report | None = None
) -> list[list[list[Deployment]]]:
    """Deploy a decision list in every instance of every run; `settings.rules` and `settings.search` are not looked at.

    Returns:
        For each of the settings, for each of its instances, the deployments in order.

    Raises:
        InputError: a setting is impossible.
    """
    report = report or Quiet()
    size = len(decisions.rules)
    sized = [dataclasses.replace(one, rules=dataclasses.replace(one.rules, rules=size)) for one in settings]
    tasks = [_tasks(one, decisions, deployments) for one in sized]
    every = [task for own in tasks for task in own]

    def tell() -> None:
        report.generation(
            done=[len(task.taken) for task in every],
            best=[max((one.fitness for one in task.deployments), default=math.nan) for task in every],
            evaluations=sum(len(task.taken) for task in every),
            env_steps=sum(task.useful_steps for task in every),
        )

    groups: dict[object, list[int]] = {}
    for place, one in enumerate(sized):
        groups.setdefault(batch_key(one), []).append(place)
    for places in groups.values():
        own = [task for place in places for task in tasks[place]]
        play(make_batches(sized[places[0]], [decisions], own, policy=FirstMatch(), note=report.note), tell)
    return [[task.deployments for task in own] for own in tasks]


def _tasks(settings: Settings, decisions: DecisionList, deployments: int) -> list[Measurement]:
    rules = decisions.rule_sets(settings.swarm.agents)
    task = task_of(settings)
    scenarios = [make_scenario(settings, settings.seed + instance) for instance in range(settings.instances)]
    sites = [Site(scenario, decisions.channels_used, settings.swarm.packets, task) for scenario in scenarios]
    return [Measurement(site, rules, deployments) for site in sites]
