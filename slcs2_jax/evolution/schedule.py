"""Which deployment goes into which slot: first those certain to count, then those that may."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from slcs2_jax.evolution.tasks import Name, Task
from slcs2_jax.rollout import Rollout

FURTHEST = 8  # deployments ahead of the certain ones that may be computed before it is known whether they count


def play(tasks: Sequence[Task], rollout: Rollout, after_chunk: Callable[[], None]) -> None:
    """Compute deployments until every task is finished.

    Deployments that may turn out not to count fill slots that would be idle otherwise; those that are no longer wanted
    are dropped. What a task receives, and so every result, is the same as without them.
    """
    flying: dict[int, tuple[Task, Name]] = {}
    while not all(task.finished for task in tasks):
        _fill(tasks, rollout, flying)
        for done in rollout.advance():
            task, name = flying.pop(done.slot)
            if name in task.wanted(FURTHEST):
                task.take(name, done)
        for slot, (task, name) in list(flying.items()):
            if name not in task.wanted(FURTHEST):
                rollout.cancel(slot)
                del flying[slot]
        after_chunk()


def _fill(tasks: Sequence[Task], rollout: Rollout, flying: dict[int, tuple[Task, Name]]) -> None:
    vacant = rollout.vacant()
    if not vacant:
        return
    busy = {(id(task), name) for task, name in flying.values()}
    for task, name in _queue(tasks):
        if (id(task), name) in busy:
            continue
        slot = vacant.pop(0)
        rollout.place(slot, task.job(name))
        flying[slot] = (task, name)
        busy.add((id(task), name))
        if not vacant:
            return


def _queue(tasks: Sequence[Task]) -> Iterator[tuple[Task, Name]]:
    """Certain deployments of all tasks, then further and further ahead, the most hopeful tasks first."""
    going = [task for task in tasks if not task.finished]
    for task in going:
        for name in task.wanted(0):
            yield task, name
    going.sort(key=lambda task: -task.hope)
    for ahead in range(1, FURTHEST + 1):
        for task in going:
            for name in task.wanted(ahead):
                yield task, name
