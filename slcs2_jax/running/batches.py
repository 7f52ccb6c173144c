"""Slots for tasks: how many, on which devices, and who shares them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from slcs2_jax import runtime
from slcs2_jax.config import Settings
from slcs2_jax.episode import Parameters
from slcs2_jax.policy.protocol import Controller
from slcs2_jax.rollout import LANES, Rollout, Shape
from slcs2_jax.running.schedule import Batch
from slcs2_jax.running.task import Task
from slcs2_jax.world.arena import wall_capacity

MOST_BATCHES = 4  # rollouts, for scenarios with more and more walls
LEAST_TASKS = 12  # that each of these rollouts should have


class Rollouts:
    """Makes the rollouts of some settings, and keeps them for those who come again with what fits into one.

    What a deployment comes to does not depend on what its rollout has room for beyond what it needs.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._devices = runtime.devices(settings.compute)
        self._kept: dict[Controller, list[tuple[Shape, Rollout]]] = {}

    def get(self, controller: Controller, shape: Shape, width: int, taken: Sequence[Rollout] = ()) -> Rollout:
        """Vacant slots of this shape or more, `width` per device; none of those `taken`.

        A kept rollout has up to twice the walls and at least half the slots that are asked for; one that is made takes
        the place of those that it could replace.
        """
        kept = self._kept.setdefault(controller, [])
        slots = width * len(self._devices)
        for room, rollout in kept:
            fits = covers(room, shape) and 2 * rollout.slots >= slots
            if fits and sum(room.walls) <= 2 * sum(shape.walls) and rollout not in taken:
                return rollout
        parameters = Parameters.of(self._settings, controller)
        made = Rollout(parameters, shape, slots=slots, devices=self._devices, chunk=self._settings.compute.chunk)
        kept[:] = [(room, one) for room, one in kept if one in taken or not covers(shape, room)]
        kept.append((shape, made))
        return made

    def forget(self) -> None:
        """Keep none: after an interruption their slots may be taken."""
        self._kept.clear()


def covers(shape: Shape, other: Shape) -> bool:
    """Has it room for all that the other one has room for? Agents and rules must be as many."""
    same = (shape.agents, shape.rules) == (other.agents, other.rules)
    room = shape.words >= other.words and shape.channels >= other.channels
    return same and room and all(mine >= its for mine, its in zip(shape.walls, other.walls, strict=True))


def make_batches(
    settings: Settings, tasks: Sequence[Task], *, width: int | None = None, rollouts: Rollouts | None = None
) -> list[Batch]:
    """Slots for the tasks, ``width`` per device, else as ``settings.compute`` says or as the devices like it.

    All tasks deploy policies of one controller with as many rules. The slots of a rollout all have room for the walls
    of the fullest scenario, and cost as much as if they were used; so tasks are parted by the number of walls where
    there are enough of them to keep several rollouts busy.

    Args:
        settings: that all tasks have in common.
        tasks: at least one.
        width: slots per device.
        rollouts: where to take them from, if some may be there already.
    """
    width = width or slots_per_device(settings, sum(len(task.wanted(0)) for task in tasks))
    rollouts = rollouts or Rollouts(settings)
    by_walls = sorted(tasks, key=lambda task: sum(wall_capacity([task.site.scenario])))
    kinds = len({wall_capacity([task.site.scenario]) for task in tasks})
    on_cpu = runtime.devices(settings.compute)[0].platform == "cpu"  # a GPU takes all of them at once
    parts = max(1, min(MOST_BATCHES, kinds, len(tasks) // LEAST_TASKS)) if on_cpu else 1
    cuts = [len(tasks) * part // parts for part in range(parts + 1)]
    controller = tasks[0].policy.controller
    batches: list[Batch] = []
    for start, stop in itertools.pairwise(cuts):
        some = by_walls[start:stop]
        shape = _shape(settings, tasks, some)
        batches.append(Batch(some, rollouts.get(controller, shape, width, [batch.rollout for batch in batches])))
    return batches


def _shape(settings: Settings, tasks: Sequence[Task], some: Sequence[Task]) -> Shape:
    """Room for what any task's rules can say, and for the walls of some."""
    policies: list[Any] = [task.policy for task in tasks]
    return Shape(
        agents=settings.swarm.agents,
        rules=policies[0].size,
        words=max(policy.words for policy in policies),
        channels=1 + max(max(policy.channels) for policy in policies),
        walls=wall_capacity([task.site.scenario for task in some]),
    )


def slots_per_device(settings: Settings, tasks: int) -> int:
    """Slots per device: CPUs are fastest with one vector's width; a GPU takes twice what is certain to be wanted."""
    devices = runtime.devices(settings.compute)
    enough = LANES * len(devices) if devices[0].platform == "cpu" else 2 * tasks
    return -(-(settings.compute.slots or enough) // (LANES * len(devices))) * LANES
