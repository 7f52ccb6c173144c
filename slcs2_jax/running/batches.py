"""Slots for tasks: how many, on which devices, and who shares them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

from slcs2_jax import runtime
from slcs2_jax.config import Settings
from slcs2_jax.episode import Parameters, physical
from slcs2_jax.grammar.language import Language
from slcs2_jax.rollout import LANES, Rollout, Shape
from slcs2_jax.running.deployable import joined, program
from slcs2_jax.running.schedule import Batch
from slcs2_jax.running.task import Task
from slcs2_jax.world.arena import wall_capacity
from slcs2_jax.world.emitters import jammer_room

MOST_BATCHES = 4  # rollouts, for scenarios with more and more walls
LEAST_TASKS = 12  # that each of these rollouts should have


@dataclass(frozen=True, eq=False)
class _Kept:
    """A rollout, and what it has room for."""

    rollout: Rollout
    shape: Shape
    language: Language
    physics: Hashable  # what its values are made of

    def serves(self, shape: Shape, language: Language, physics: Hashable) -> bool:
        """Has it room for all of this? Where the native chunk computes, every slot has values of its own."""
        if not (self.rollout.native or self.physics == physics):
            return False
        mine, its = self.language, language
        says = mine.words >= its.words and {*mine.own_clauses} >= {*its.own_clauses}
        does = {*mine.own_actions} >= {*its.own_actions}
        same = (self.shape.agents, self.shape.jammers) == (shape.agents, shape.jammers)
        room = same and self.shape.channels >= shape.channels
        return says and does and room and all(a >= b for a, b in zip(self.shape.walls, shape.walls, strict=True))


class Rollouts:
    """Makes the rollouts of some settings, and keeps them for those who come again with what fits into one.

    What a deployment comes to does not depend on what its rollout has room for beyond what it needs.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._devices = runtime.devices(settings.compute)
        self._kept: dict[Hashable, list[_Kept]] = {}

    def get(self, tasks: Sequence[Task], everybody: Sequence[Task], width: int, taken: Sequence[Rollout]) -> Rollout:
        """Vacant slots, `width` per device, for some tasks, with room for what `everybody` can say; none of `taken`.

        A kept rollout has up to twice the walls and at least half the slots that are asked for; one that is made takes
        the place of those that it could replace. Where XLA computes, its physical values are those of the first task.
        """
        language = joined([task.policy.language for task in everybody])
        channels = 1 + max(max(task.policy.channels) for task in everybody)
        scenarios = [scenario for task in tasks for scenario in task.site.scenarios]
        walls, jammers = wall_capacity(scenarios), jammer_room(scenarios)
        shape = Shape(agents=self._settings.swarm.agents, channels=channels, walls=walls, jammers=jammers)
        physics = physical(tasks[0].site.settings)
        kept, slots = self._kept.setdefault(program(tasks[0].policy), []), width * len(self._devices)
        for one in kept:
            enough = one.serves(shape, language, physics) and 2 * one.rollout.slots >= slots
            if enough and sum(one.shape.walls) <= 2 * sum(walls) and one.rollout not in taken:
                return one.rollout
        made = _Kept(self._made(tasks[0], shape, language, slots), shape, language, physics)
        kept[:] = [one for one in kept if one.rollout in taken or not made.serves(one.shape, one.language, one.physics)]
        kept.append(made)
        return made.rollout

    def _made(self, task: Task, shape: Shape, language: Language, slots: int) -> Rollout:
        policy, compute = task.policy.policy, self._settings.compute
        parameters = Parameters.of(task.site.settings, policy, language)
        like = policy.arrays(task.policy.given, language)
        return Rollout(
            parameters,
            shape,
            like,
            slots=slots,
            devices=self._devices,
            chunk=compute.chunk,
            engine=compute.native,
        )

    def forget(self) -> None:
        """Keep none: after an interruption their slots may be taken."""
        self._kept.clear()


def make_batches(
    settings: Settings,
    tasks: Sequence[Task],
    *,
    width: int | None = None,
    rollouts: Rollouts | None = None,
    note: Callable[[str], None] = lambda text: None,
) -> list[Batch]:
    """Slots for the tasks, ``width`` per device, else as ``settings.compute`` says or as the devices like it.

    All tasks deploy policies of one `program`. The slots of a rollout all have room for the walls
    of the fullest scenario, and cost as much as if they were used; so tasks are parted by the number of walls where
    there are enough of them to keep several rollouts busy. Where XLA computes, whose programs take one value for all of
    their episodes, tasks that differ in physical values have rollouts of their own.

    Args:
        settings: of one of the tasks, which differ in physical values at most.
        tasks: at least one.
        width: slots per device.
        rollouts: where to take them from, if some may be there already.
        note: told why XLA computes, where the native chunk could not.
    """
    width = width or slots_per_device(settings, sum(len(task.wanted(0)) for task in tasks))
    rollouts = rollouts or Rollouts(settings)
    by_walls = sorted(tasks, key=lambda task: sum(wall_capacity(task.site.scenarios)))
    kinds = len({wall_capacity(task.site.scenarios) for task in tasks})
    on_cpu = runtime.devices(settings.compute)[0].platform == "cpu"  # a GPU takes all of them at once
    parts = max(1, min(MOST_BATCHES, kinds, len(tasks) // LEAST_TASKS)) if on_cpu else 1
    cuts = [len(tasks) * part // parts for part in range(parts + 1)]
    left = [by_walls[start:stop] for start, stop in itertools.pairwise(cuts)]
    batches: list[Batch] = []
    while left:
        some = left.pop(0)
        rollout = rollouts.get(some, tasks, width, [batch.rollout for batch in batches])
        if not rollout.native:
            physics = physical(some[0].site.settings)
            others = [task for task in some if physical(task.site.settings) != physics]
            some = [task for task in some if task not in others]
            left[:0] = [others] if others else []
        batches.append(Batch(some, rollout))
    for text in dict.fromkeys(batch.rollout.note for batch in batches):
        if text is not None:
            note(text)
    return batches


def slots_per_device(settings: Settings, tasks: int) -> int:
    """Slots per device: CPUs are fastest with one vector's width; a GPU takes twice what is certain to be wanted."""
    devices = runtime.devices(settings.compute)
    enough = LANES * len(devices) if devices[0].platform == "cpu" else 2 * tasks
    return -(-(settings.compute.slots or enough) // (LANES * len(devices))) * LANES
