"""Episodes in bulk: slots on one or many devices, refilled as their episodes end. The only place that batches."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Hashable, Sequence
from typing import Any

import jax
import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import Settings
from slcs2_jax.config.errors import InputError
from slcs2_jax.episode import Parameters, Result, physical
from slcs2_jax.native import choice
from slcs2_jax.native.slots import NativeSlots
from slcs2_jax.policy.policy import Figures
from slcs2_jax.programs import CompiledSlots
from slcs2_jax.world.arena import stack
from slcs2_jax.world.emitters import JammerRoom
from slcs2_jax.world.scenario import Scenario

LANES = 16  # slots per device come in multiples of this: what vector units take at a time


@dataclasses.dataclass(frozen=True)
class Shape:
    """Static sizes of a batch: agents, channels, rows for walls, room for jammers."""

    agents: int
    channels: int
    walls: tuple[int, int]
    jammers: JammerRoom | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class Job:
    """One deployment to compute.

    Attributes:
        name: what the caller knows it by.
        scenario: the world.
        channels: indices of the channels that the policy uses.
        given: what `Policy.arrays` makes the policy's parameters of, of the same sizes in all jobs of a rollout.
        key: the episode's key, two 32-bit words.
        settings: whose physical values it has; None for those of the rollout.
    """

    name: Hashable
    scenario: Scenario
    channels: tuple[int, ...]
    given: Any
    key: tuple[np.uint32, np.uint32]
    settings: Settings | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class Done:
    """What the deployment in a slot measured.

    Attributes:
        slot: where it was computed.
        job: what was asked for.
        steps, delivered: T_s and p_s.
        contribution: int32 [n], delivered packets that the agent had held.
        figures: [n, R], what rules have learnt; None for a policy without rules.
        measures: what the task took from the last state, by name.
    """

    slot: int
    job: Job
    steps: int
    delivered: int
    contribution: NDArray[np.int32]
    figures: Figures | None
    measures: dict[str, NDArray[Any]]


class Rollout:
    """A fixed number of slots that hold episodes of jobs; jobs are placed in vacant slots between chunks of steps."""

    def __init__(
        self,
        parameters: Parameters,
        shape: Shape,
        like: Any,
        *,
        slots: int,
        devices: Sequence[jax.Device],
        chunk: int,
        engine: str = "auto",
    ) -> None:
        """Set up vacant slots.

        Args:
            parameters: of every episode, but that jobs may have values of their own where the native chunk computes.
            shape: static sizes.
            like: a deployment's `Policy.arrays`, for their structure, shapes and types.
            slots: how many, rounded up to whole ``LANES`` per device.
            devices: spread over these.
            chunk: steps between refills, rounded to whole sharing periods.
            engine: `compute.native`, whether the native chunk computes: auto, on or off.

        Raises:
            InputError: the native chunk must compute, and cannot.
        """
        whole = LANES * len(devices)
        self.slots = -(-slots // whole) * whole
        self.slot_steps = 0  # all steps computed, of lanes or slots without a job and finished episodes too
        self._periods = max(1, round(chunk / parameters.sharing_period))
        self._parameters, self._shape = parameters, shape
        self._values: dict[Hashable, Parameters] = {}  # of jobs, by what they are made of
        self._jobs: list[Job | None] = [None] * self.slots
        self._like = [(leaf.shape, leaf.dtype) for leaf in jax.tree.leaves(like)]
        arena, policies = _vacant(shape, like, self.slots)
        start = time.perf_counter()
        self.native, self.note = choice.choose(engine, devices[0].platform, parameters, arena, policies)
        self._in: NativeSlots | CompiledSlots
        if self.native:
            self._in = NativeSlots(parameters, arena, policies, periods=self._periods, threads=len(devices))
        else:
            self._in = CompiledSlots(parameters, arena, policies, periods=self._periods, devices=devices)
        self.compile_seconds = time.perf_counter() - start

    @property
    def held_bytes(self) -> int:
        """Of the arrays that episodes are in, on the devices or the host."""
        return self._in.held_bytes

    @property
    def steps_per_chunk(self) -> int:
        """Time-steps that ``advance`` makes."""
        return self._periods * self._parameters.sharing_period

    @property
    def compiled(self) -> str:
        """The text of XLA's program for a chunk; nothing where the native chunk computes."""
        return self._in.compiled if isinstance(self._in, CompiledSlots) else ""

    def vacant(self) -> list[int]:
        """Slots without a job."""
        return [slot for slot, job in enumerate(self._jobs) if job is None]

    def room(self, certain: int) -> int:
        """How many jobs cost little more than so many do that must be computed: at most all slots."""
        return self._in.room(certain)

    def place(self, slot: int, job: Job) -> None:
        """Give a vacant slot a job; it starts with the next ``advance``.

        Where XLA computes the job's settings must have the rollout's values.
        """
        policy, language = self._parameters.policy, self._parameters.physics.language
        arrays = policy.arrays(job.given, language)
        found = [(leaf.shape, leaf.dtype) for leaf in jax.tree.leaves(arrays)]
        if found != self._like:
            raise InputError(f"policy: its arrays are {found}; accepted are {self._like}, as the others have")
        shape = self._shape
        one = stack([job.scenario], [job.channels], capacity=shape.walls, width=shape.channels, jammers=shape.jammers)
        if isinstance(self._in, NativeSlots):
            self._in.place(slot, one, arrays, job.key, self._parameters_of(job))
        else:
            self._in.place(slot, one, arrays, job.key)
        self._jobs[slot] = job

    def _parameters_of(self, job: Job) -> Parameters | None:
        """The rollout's with a job's values, NumPy arrays; None if it brings none."""
        if job.settings is None:
            return None
        origin = physical(job.settings)
        if origin not in self._values:
            values = jax.tree.map(np.asarray, jax.tree.leaves(Parameters.of(job.settings)))
            self._values[origin] = jax.tree.unflatten(jax.tree.structure(self._parameters), values)
        return self._values[origin]

    def cancel(self, slot: int) -> None:
        """Forget the job of a slot; what it computed is lost, and what it has yet to compute will not be."""
        self._jobs[slot] = None
        self._in.cancel(slot)

    def advance(self) -> list[Done]:
        """Compute one chunk of steps for every job; returns what has finished and vacates its slots."""
        ended = self._in.advance()
        self.slot_steps += self._in.computed * self.steps_per_chunk
        if not ended:
            return []
        result = self._in.results(ended)
        return [self._take(slot, place, result) for place, slot in enumerate(ended)]

    def _take(self, slot: int, place: int, result: Result) -> Done:
        job = self._jobs[slot]
        assert job is not None
        self._jobs[slot] = None
        return Done(
            slot=slot,
            job=job,
            steps=int(result.steps[place]),
            delivered=int(result.delivered[place]),
            contribution=np.array(result.contribution[:, place]),
            figures=jax.tree.map(lambda leaf: leaf[..., place].T.copy(), result.figures),
            measures=jax.tree.map(lambda leaf: leaf[..., place].copy(), result.measures),
        )


def _vacant(shape: Shape, like: Any, slots: int) -> tuple[Any, Any]:
    """Host arrays for the slots; a vacant slot has no time at all, so that its episode is over."""
    nowhere = Scenario(
        environment="vacant",
        seed=0,
        sink=np.zeros(2, np.float32),
        sink_estimate=np.zeros(2, np.float32),
        jammers=(),
        vertical=np.zeros((0, 3), np.float32),
        horizontal=np.zeros((0, 3), np.float32),
        wall_thickness=0.0,
        start=np.zeros((shape.agents, 2), np.float32),
        time_limit=0,
    )
    arena = stack([nowhere] * slots, [(0,)] * slots, capacity=shape.walls, width=shape.channels, jammers=shape.jammers)
    policies = jax.tree.map(lambda leaf: np.zeros((*leaf.shape, slots), leaf.dtype), like)
    return arena, policies
