"""The simulator at work: a fixed number of slots, always busy, and how many of their steps were useful."""

from __future__ import annotations

import math
from collections.abc import Callable

import jax

from benchmarks.rounds import Play, clock
from benchmarks.workload import Workload
from slcs2_jax import runtime
from slcs2_jax.episode import Parameters
from slcs2_jax.policy.rules import Rules
from slcs2_jax.rollout import Job, Rollout, Shape
from slcs2_jax.world.arena import wall_capacity


def make_rollout(workload: Workload, slots: int, engine: str | None = None) -> Rollout:
    """At least so many slots for the workload, its programs compiled; `engine`: in place of its `compute.native`."""
    settings = workload.settings
    shape = Shape(
        agents=settings.swarm.agents,
        channels=1 + max(workload.channels),
        walls=wall_capacity(workload.scenarios),
    )
    parameters = Parameters.of(settings, language=workload.language)
    return Rollout(
        parameters,
        shape,
        Rules.like(settings.rules.rules, settings.swarm.agents, workload.language),
        slots=slots,
        devices=runtime.devices(settings.compute),
        chunk=settings.compute.chunk,
        engine=engine or settings.compute.native,
    )


def play(rollout: Rollout, job: Callable[[int], Job], busy: int, steps: int) -> Play:
    """Advance the slots by at least so many steps, ``busy`` of them working; measured from the first placement on.

    A slot whose episode ends gets the next one. An episode that ended counts with its steps; one that is under way at
    the end was running in every chunk since it was placed. The other slots' steps count for nothing.
    """
    before, chunks = rollout.slot_steps, math.ceil(steps / rollout.steps_per_chunk)
    running: dict[int, tuple[Job, int]] = {}
    lengths: list[int] = []
    placed = 0
    start = clock.now()
    for chunk in range(chunks):
        for slot in rollout.vacant()[: busy - len(running)]:
            running[slot] = job(placed), chunk
            rollout.place(slot, running[slot][0])
            placed += 1
        for done in rollout.advance():
            del running[done.slot]
            lengths.append(done.steps)
    jax.block_until_ready(jax.live_arrays())
    seconds = clock.now() - start
    under_way = sum((chunks - since) * rollout.steps_per_chunk for _, since in running.values())
    for slot in running:
        rollout.cancel(slot)
    return Play(seconds, sum(lengths) + under_way, rollout.slot_steps - before, tuple(lengths))
