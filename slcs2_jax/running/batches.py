"""Slots for tasks: how many, on which devices, and who shares them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

from slcs2_jax import runtime
from slcs2_jax.config import Settings
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar.language import Language, Sayer
from slcs2_jax.policy.policy import Policy
from slcs2_jax.policy.rules import Rules
from slcs2_jax.rollout import LANES, Rollout, Shape
from slcs2_jax.running.instance import Site, Task
from slcs2_jax.running.schedule import Batch
from slcs2_jax.world.arena import wall_capacity
from slcs2_jax.world.emitters import jammer_room

MOST_BATCHES = 4  # rollouts, for scenarios with more and more walls
LEAST_TASKS = 12  # that each of these rollouts should have


def make_batches(
    settings: Settings,
    said: Sequence[Sayer],
    tasks: Sequence[Task],
    *,
    width: int | None = None,
    policy: Policy | None = None,
    note: Callable[[str], None] = lambda text: None,
) -> list[Batch]:
    """Slots for the tasks, ``width`` per device, else as ``settings.compute`` says or as the devices like it.

    The slots of a rollout all have room for the walls of the fullest scenario, and cost as much as if they were used;
    so tasks are parted by the number of walls where there are enough of them to keep several rollouts busy.
    `note` is told if XLA computes what the native chunk should.
    """
    width = width or slots_per_device(settings, sum(len(task.wanted(0)) for task in tasks))
    by_walls = sorted(tasks, key=lambda task: sum(wall_capacity([task.site.scenario])))
    kinds = len({wall_capacity([task.site.scenario]) for task in tasks})
    on_cpu = runtime.devices(settings.compute)[0].platform == "cpu"  # a GPU takes all of them at once
    parts = max(1, min(MOST_BATCHES, kinds, len(tasks) // LEAST_TASKS)) if on_cpu else 1
    cuts = [len(tasks) * part // parts for part in range(parts + 1)]
    batches = [
        Batch(some, _rollout(settings, said, [task.site for task in some], width, policy))
        for some in (by_walls[start:stop] for start, stop in itertools.pairwise(cuts))
    ]
    for text in dict.fromkeys(batch.rollout.note for batch in batches):
        if text is not None:
            note(text)
    return batches


def _rollout(
    settings: Settings, said: Sequence[Sayer], sites: Sequence[Site], width: int, policy: Policy | None
) -> Rollout:
    shape = Shape(
        agents=settings.swarm.agents,
        channels=1 + max(max(one.channels_used) for one in said),
        walls=wall_capacity([site.scenario for site in sites]),
        jammers=jammer_room([site.scenario for site in sites]),
    )
    devices = runtime.devices(settings.compute)
    language = Language.of(said)
    parameters = Parameters.of(settings, policy, language)
    slots = width * len(devices)
    like = Rules.like(settings.rules.rules, settings.swarm.agents, language)
    chunk, engine = settings.compute.chunk, settings.compute.native
    return Rollout(parameters, shape, like, slots=slots, devices=devices, chunk=chunk, engine=engine)


def slots_per_device(settings: Settings, tasks: int) -> int:
    """Slots per device: CPUs are fastest with one vector's width; a GPU takes twice what is certain to be wanted."""
    devices = runtime.devices(settings.compute)
    enough = LANES * len(devices) if devices[0].platform == "cpu" else 2 * tasks
    return -(-(settings.compute.slots or enough) // (LANES * len(devices))) * LANES
