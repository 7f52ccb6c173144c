"""Which deployment goes into which slot: first those certain to count, then those that may."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Sequence

from slcs2_jax.rollout import Rollout
from slcs2_jax.running.task import Name, Task
from slcs2_jax.running.usage import Usage

FURTHEST = 8  # deployments ahead of the certain ones that may be computed before it is known whether they count


class Batch:
    """Tasks that share the slots of a rollout, and what is in the slots."""

    def __init__(self, tasks: Sequence[Task], rollout: Rollout) -> None:
        self.tasks, self.rollout = tasks, rollout
        self.device_seconds = 0.0
        self.compile_seconds = 0.0 if rollout.slot_steps else rollout.compile_seconds  # of one that worked before, none
        self._flying: dict[int, tuple[Task, Name]] = {}

    @property
    def finished(self) -> bool:
        """All of its tasks are."""
        return all(task.finished for task in self.tasks)

    def advance(self) -> None:
        """Fill the slots, compute a chunk of steps, and hand over what has ended.

        Deployments that may turn out not to count fill slots that would be idle otherwise, as far as `Rollout.room`
        goes. Where the native chunk computes, which idle slots do not cost what others do, they must be likely to
        count: a solution is deployed again if its fitness is positive (paper, Re-Evaluation). Those that are no longer
        wanted are dropped. What a task receives, and so every result, is the same as without them.
        """
        self._fill()
        dispatched = time.perf_counter()
        ended = self.rollout.advance()
        self.device_seconds += time.perf_counter() - dispatched
        for done in ended:
            task, name = self._flying.pop(done.slot)
            if task.wants(name):
                task.take(name, done)
        if ended:
            self._drop_unwanted()

    def _drop_unwanted(self) -> None:
        for slot, (task, name) in list(self._flying.items()):
            if not task.wants(name):
                self.rollout.cancel(slot)
                del self._flying[slot]

    def _fill(self) -> None:
        vacant = self.rollout.vacant()
        if not vacant:
            return
        busy = {(id(task), name) for task, name in self._flying.values()}
        going = [task for task in self.tasks if not task.finished]
        certain = [(task, name) for task in going for name in task.wanted(0)]
        room = self.rollout.room(len(certain))
        likely = [task for task in going if task.expected_fitness >= 0 or not self.rollout.native]
        for number, (task, name) in enumerate(itertools.chain(certain, _ahead(likely))):
            if (id(task), name) in busy:
                continue
            if not vacant or (number >= len(certain) and len(busy) >= room):
                return
            slot = vacant.pop(0)
            self.rollout.place(slot, task.job(name))
            self._flying[slot] = (task, name)
            busy.add((id(task), name))


def play(batches: Sequence[Batch], after_chunk: Callable[[], None]) -> Usage:
    """Compute deployments until every task is finished, the batches by turns; returns where the time went."""
    start = time.perf_counter()
    tasks = [task for batch in batches for task in batch.tasks]
    slot_steps = sum(batch.rollout.slot_steps for batch in batches)
    useful_steps = sum(task.useful_steps for task in tasks)
    device_seconds = sum(batch.device_seconds for batch in batches)
    while going := [batch for batch in batches if not batch.finished]:
        for batch in going:
            batch.advance()
            after_chunk()
    device_seconds = sum(batch.device_seconds for batch in batches) - device_seconds
    return Usage(
        compile_seconds=sum(batch.compile_seconds for batch in batches),
        device_seconds=device_seconds,
        host_seconds=time.perf_counter() - start - device_seconds,
        slot_steps=sum(batch.rollout.slot_steps for batch in batches) - slot_steps,
        useful_steps=sum(task.useful_steps for task in tasks) - useful_steps,
    )


def _ahead(tasks: Sequence[Task]) -> Iterator[tuple[Task, Name]]:
    """Deployments that may count: of the likely ones first, then of the tasks that are behind the others."""
    for task in sorted(tasks, key=lambda task: (task.expected_fitness <= 0, task.generation, -task.expected_fitness)):
        for name in task.wanted(FURTHEST):
            yield task, name
