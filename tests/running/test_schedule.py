"""The schedule: certain deployments first, then those that may count; what a task receives is the same without them."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import pytest

from slcs2_jax.running.schedule import FURTHEST, Batch, play
from slcs2_jax.search import counted


@dataclass
class Done:
    slot: int
    job: object


class Rollout:
    """Slots whose jobs take a number of chunks that follows from the job, so that they end in a jumbled order."""

    def __init__(self, slots: int, *, longest: int = 4, native: bool = False, lanes: int = 1) -> None:
        self.slots, self.longest, self.native, self.lanes = slots, longest, native, lanes
        self.jobs: dict[int, object] = {}
        self.left: dict[int, int] = {}
        self.placed: list[object] = []
        self.cancelled: list[object] = []
        self.most = 0
        self.compile_seconds, self.slot_steps = 0.5, 0

    def vacant(self) -> list[int]:
        return [slot for slot in range(self.slots) if slot not in self.jobs]

    def room(self, certain: int) -> int:
        return self.lanes * -(-certain // self.lanes) if self.native else self.slots

    def place(self, slot: int, job: object) -> None:
        assert slot not in self.jobs, "the slot is taken"
        assert job not in self.jobs.values(), "computed twice at once"
        self.jobs[slot], self.left[slot] = job, random.Random(repr(job)).randint(1, self.longest)
        self.placed.append(job)
        self.most = max(self.most, len(self.jobs))

    def cancel(self, slot: int) -> None:
        self.cancelled.append(self.jobs.pop(slot))

    def advance(self) -> list[Done]:
        assert self.jobs, "nothing to compute"
        self.slot_steps += 10 * self.slots
        for slot in self.jobs:
            self.left[slot] -= 1
        return [Done(slot, self.jobs.pop(slot)) for slot in sorted(self.jobs) if self.left[slot] == 0]


@dataclass(eq=False)
class Task:
    """Generations of solutions whose fitnesses follow from their names, evaluated by the project's rule."""

    seed: int
    generations: int = 5
    redeployments: int = 5
    expected_fitness: float = 0.0
    generation: int = 0
    held: dict[int, float] = field(default_factory=dict)
    useful_steps: int = 0
    rows: list[tuple[float, ...]] = field(default_factory=list)

    @property
    def finished(self) -> bool:
        return self.generation == self.generations

    def _prefix(self) -> list[float]:
        values: list[float] = []
        while len(values) in self.held:
            values.append(self.held[len(values)])
        return values

    def wanted(self, ahead: int) -> list[tuple[str, int, int]]:
        if self.finished:
            return []
        made = len(self._prefix())
        stop = min(self.redeployments + 1, made + 1 + ahead)
        return [("search", self.generation, index) for index in range(made, stop) if index not in self.held]

    def wants(self, name) -> bool:
        return name in self.wanted(FURTHEST)

    def job(self, name):
        return (self.seed, *name)

    def take(self, name, done: Done) -> None:
        assert done.job == (self.seed, *name), "somebody else's deployment"
        assert self.wants(name), "not wanted"
        self.held[name[2]] = random.Random(repr(done.job)).uniform(-0.6, 1.0)
        values = self._prefix()
        count = counted(values, min_deployments=1, max_redeployments=self.redeployments)
        if count is not None:
            self.rows.append(tuple(values[:count]))
            self.useful_steps += 10 * count
            self.generation, self.held = self.generation + 1, {}


def one_after_the_other(task: Task) -> list[tuple[float, ...]]:
    """The task's rows, computed without a schedule."""
    while not task.finished:
        [name] = task.wanted(0)
        task.take(name, Done(0, task.job(name)))
    return task.rows


@pytest.mark.parametrize("slots", [1, 2, 3, 7, 20, 64])
@pytest.mark.parametrize("tasks", [1, 3, 8])
def test_results_do_not_depend_on_the_slots(slots, tasks):
    played = [Task(seed, expected_fitness=random.Random(seed).uniform(-1, 1)) for seed in range(tasks)]
    play([Batch(played, Rollout(slots))], lambda: None)
    assert [task.rows for task in played] == [one_after_the_other(Task(seed)) for seed in range(tasks)]
    assert len({len(row) for task in played for row in task.rows}) > 1, "all evaluations are of one length"


def test_one_slot_computes_nothing_that_does_not_count():
    task, rollout = Task(3), Rollout(1)
    play([Batch([task], rollout)], lambda: None)
    assert rollout.cancelled == []
    assert len(rollout.placed) == sum(map(len, task.rows))


def test_certain_deployments_come_first_then_the_likely_ones_of_those_who_are_behind():
    fitness = {0: -0.5, 1: 0.9, 2: 0.1, 3: 0.2}
    tasks = [Task(seed, expected_fitness=value, generation=int(seed == 1)) for seed, value in fitness.items()]
    rollout = Rollout(16)
    with pytest.raises(StopIteration):
        play([Batch(tasks, rollout)], stop)
    assert [job[0] for job in rollout.placed] == [0, 1, 2, 3] + [3] * 5 + [2] * 5 + [1] * 2
    assert [job[3] for job in rollout.placed[4:9]] == [1, 2, 3, 4, 5]


def test_where_idle_slots_cost_nothing_only_likely_deployments_fill_them_as_far_as_there_is_room():
    for lanes, expected in ((4, [0, 1, 2, 1]), (16, [0, 1, 2] + [1] * 5 + [2] * 5)):
        tasks = [Task(seed, expected_fitness=value) for seed, value in enumerate([-0.5, 0.9, 0.0])]
        rollout = Rollout(20, native=True, lanes=lanes)
        with pytest.raises(StopIteration):
            play([Batch(tasks, rollout)], stop)
        assert [job[0] for job in rollout.placed] == expected


def test_certain_deployments_are_begun_whatever_room_there_is():
    tasks = [Task(seed, expected_fitness=0.5) for seed in range(5)]
    rollout = Rollout(5, native=True, lanes=4)
    play([Batch(tasks, rollout)], lambda: None)
    assert [task.rows for task in tasks] == [one_after_the_other(Task(seed)) for seed in range(5)]


def test_idle_slots_look_no_further_than_may_count():
    task, rollout = Task(0), Rollout(64)
    with pytest.raises(StopIteration):
        play([Batch([task], rollout)], stop)
    assert [job[3] for job in rollout.placed] == list(range(6))


def test_deployments_that_are_no_longer_wanted_are_dropped():
    tasks = [Task(seed) for seed in range(4)]
    rollout = Rollout(16)
    play([Batch(tasks, rollout)], lambda: None)
    assert rollout.cancelled, "nothing was in vain"
    assert rollout.jobs == {}, "something is left over"
    assert len(rollout.placed) == len(set(rollout.placed)), "a deployment was begun twice"
    assert rollout.most == 16


def test_finished_tasks_ask_for_nothing_and_the_others_go_on():
    tasks = [Task(0, generations=1), Task(1, generations=6), Task(2, generations=0)]
    rollout = Rollout(3)
    play([Batch(tasks, rollout)], lambda: None)
    assert [len(task.rows) for task in tasks] == [1, 6, 0]
    assert not [job for job in rollout.placed if job[0] == 2]


def test_batches_advance_by_turns_until_all_are_finished_and_their_use_is_added_up():
    tasks = [Task(seed, generations=2 + 3 * (seed % 2)) for seed in range(4)]
    slots = [Rollout(2, longest=1), Rollout(5, longest=1)]
    batches = [Batch(tasks[:1], slots[0]), Batch(tasks[1:], slots[1])]
    before = []
    usage = play(batches, lambda: before.append([rollout.slot_steps for rollout in slots]))
    assert before[:3] == [[20, 0], [20, 50], [40, 50]]
    assert [task.rows for task in tasks] == [one_after_the_other(Task(t.seed, t.generations)) for t in tasks]
    assert usage.slot_steps == sum(rollout.slot_steps for rollout in slots)
    assert usage.useful_steps == 10 * sum(len(row) for task in tasks for row in task.rows) < usage.slot_steps
    assert usage.compile_seconds == 1.0
    assert usage.host_seconds > 0 < usage.device_seconds
    assert play(batches, stop).slot_steps == 0


def test_no_tasks_need_nothing():
    play([Batch([], Rollout(3))], stop)


def test_somebody_is_told_after_every_chunk():
    calls = []
    task, rollout = Task(0), Rollout(1, longest=1)
    play([Batch([task], rollout)], lambda: calls.append(len(task.rows)))
    assert len(calls) == len(rollout.placed)
    assert calls[-1] == task.generations


def stop() -> None:
    raise StopIteration
