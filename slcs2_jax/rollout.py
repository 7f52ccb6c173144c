"""Episodes in bulk: slots on one or many devices, refilled as their episodes end. The only place that batches."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, NamedSharding
from jax.sharding import PartitionSpec as P
from numpy.typing import NDArray

from slcs2_jax import episode as episodes
from slcs2_jax.config.errors import InputError
from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.native import advance as native
from slcs2_jax.native import choice, library
from slcs2_jax.policy.policy import Figures
from slcs2_jax.world.arena import Arena, stack
from slcs2_jax.world.emitters import JammerRoom
from slcs2_jax.world.scenario import Scenario

AXIS = "slots"
_COMPILER_OPTIONS: dict[str, dict[str, Any]] = {
    "cpu": {"xla_cpu_prefer_vector_width": 512},  # where there are none so wide: less
    # Two steps in a round of the loop, so that what one hands on need not be copied back to where the next expects it;
    # and whole loops as one CUDA graph, so that the host starts nothing within a chunk.
    "gpu": {
        "xla_gpu_enable_while_loop_unrolling": "WHILE_LOOP_UNROLLING_DOUBLE_BUFFER",
        "xla_gpu_enable_command_buffer": "FUSION,DYNAMIC_SLICE_FUSION,CUSTOM_CALL,CONDITIONAL,WHILE",
    },
}
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
    """

    name: Hashable
    scenario: Scenario
    channels: tuple[int, ...]
    given: Any
    key: tuple[np.uint32, np.uint32]


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
            parameters: of every episode.
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
        self.periods = max(1, round(chunk / parameters.sharing_period))
        self.slot_steps = 0  # all steps computed, of vacant slots and finished episodes too
        self._devices = len(devices)
        self._shape = shape
        self._policy, self._language = parameters.policy, parameters.physics.language
        self._jobs: list[Job | None] = [None] * self.slots
        self._entering = np.zeros(self.slots, bool)
        self._like = [(leaf.shape, leaf.dtype) for leaf in jax.tree.leaves(like)]
        self._arena, self._policies, self._keys = _vacant(shape, like, self.slots)
        mesh = Mesh(np.array(devices), (AXIS,))
        self._shard = partial(_place, mesh)
        self._parameters = jax.device_put(parameters, NamedSharding(mesh, P()))
        start = time.perf_counter()
        self.native, self.note = choice.choose(engine, devices[0].platform, parameters, self._arena, self._policies)
        given, structure = jax.tree.flatten((self._given(), self._parameters))
        described = tuple(jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in given)
        self._refill, self._advance, self._result = _programs(mesh, self.periods, structure, described, self.native)
        self.compile_seconds = time.perf_counter() - start
        nothing = jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), _episode(self._given(), parameters))
        self._episode = self._refill(
            self._shard(nothing), *self._given(), self._shard(np.ones(self.slots, bool)), self._parameters
        )

    @property
    def steps_per_chunk(self) -> int:
        """Time-steps that ``advance`` makes."""
        return self.periods * self._parameters.sharing_period

    def vacant(self) -> list[int]:
        """Slots without a job, in the order in which they are best filled.

        The native chunk computes slots in lane groups, and none for a group without a job: so group after group, and
        with what there is spread over all devices.
        """
        free = [slot for slot, job in enumerate(self._jobs) if job is None]
        if not self.native:
            return free
        per_device, lanes = self.slots // self._devices, library.lanes()
        return sorted(free, key=lambda slot: (slot % per_device // lanes, slot % lanes, slot))

    def place(self, slot: int, job: Job) -> None:
        """Give a vacant slot a job; it starts with the next ``advance``."""
        arrays = self._policy.arrays(job.given, self._language)
        found = [(leaf.shape, leaf.dtype) for leaf in jax.tree.leaves(arrays)]
        if found != self._like:
            raise InputError(f"policy: its arrays are {found}; accepted are {self._like}, as the others have")
        shape = self._shape
        one = stack([job.scenario], [job.channels], capacity=shape.walls, width=shape.channels, jammers=shape.jammers)
        jax.tree.map(partial(_write, slot), self._arena, one)
        jax.tree.map(lambda table, leaf: table.__setitem__((..., slot), leaf), self._policies, arrays)
        self._keys[:, slot] = job.key
        self._jobs[slot] = job
        self._entering[slot] = True

    def cancel(self, slot: int) -> None:
        """Forget the job of a slot; what it computed is lost, and what it has yet to compute will not be."""
        self._jobs[slot] = None
        self._arena.time_limit[slot] = 0
        self._entering[slot] = True

    def advance(self) -> list[Done]:
        """Compute one chunk of steps for every slot; returns what has finished and vacates its slots."""
        if self._entering.any():
            entering = self._shard(self._entering.copy())
            self._episode = self._refill(self._episode, *self._given(), entering, self._parameters)
            self._entering[:] = False
        self._episode, over = self._advance(self._episode, self._parameters)
        self.slot_steps += self._computed() * self.steps_per_chunk
        ended = [slot for slot in np.flatnonzero(np.asarray(over)) if self._jobs[slot] is not None]
        if not ended:
            return []
        result = jax.device_get(self._result(self._episode, self._parameters))
        return [self._take(int(slot), result) for slot in ended]

    def _computed(self) -> int:
        """How many slots a chunk is computed for."""
        if not self.native:
            return self.slots
        lanes = library.lanes()
        return lanes * len({slot // lanes for slot, job in enumerate(self._jobs) if job is not None})

    def _take(self, slot: int, result: Any) -> Done:
        job = self._jobs[slot]
        assert job is not None
        self._jobs[slot] = None
        return Done(
            slot=slot,
            job=job,
            steps=int(result.steps[slot]),
            delivered=int(result.delivered[slot]),
            contribution=result.contribution[:, slot].copy(),
            figures=jax.tree.map(lambda leaf: leaf[..., slot].T.copy(), result.figures),
            measures=jax.tree.map(lambda leaf: leaf[..., slot].copy(), result.measures),
        )

    def _given(self) -> tuple[Arena, Any, jax.Array]:
        """What the host holds for the slots, on the devices. Copied: the host writes into its arrays again."""
        return self._shard(jax.tree.map(np.copy, (self._arena, self._policies, self._keys)))


def _vacant(shape: Shape, like: Any, slots: int) -> tuple[Any, Any, NDArray[np.uint32]]:
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
    return arena, policies, np.zeros((2, slots), np.uint32)


def _write(slot: int, table: NDArray[Any], one: NDArray[Any]) -> None:
    table[..., slot] = one[..., 0]


def _specs(tree: Any) -> Any:
    """Every array is split along its last axis."""
    return jax.tree.map(lambda leaf: P(*(None,) * (leaf.ndim - 1), AXIS), tree)


def _place(mesh: Mesh, tree: Any) -> Any:
    return jax.device_put(tree, jax.tree.map(lambda spec: NamedSharding(mesh, spec), _specs(tree)))


def _episode(given: tuple[Arena, Any, jax.Array], parameters: Parameters) -> Any:
    """Shapes and types of the slots' episodes."""
    return jax.eval_shape(episodes.begin, *given, parameters)


@functools.lru_cache(maxsize=8)
def _programs(
    mesh: Mesh, periods: int, structure: Any, described: tuple[jax.ShapeDtypeStruct, ...], by_native: bool
) -> list[Any]:
    """The compiled programs of a rollout: refill, advance, result; each device works on its own slots.

    They are compiled side by side, since the compiler takes one core for each, and kept for the next rollout of the
    same sizes.
    """
    given, parameters = jax.tree.unflatten(structure, described)
    compiler_options = _COMPILER_OPTIONS.get(mesh.devices.flat[0].platform)
    engine: Any = native if by_native else episodes

    def refill(
        episode: Episode, arena: Arena, policy: Any, key: jax.Array, entering: jax.Array, parameters: Parameters
    ) -> Episode:
        """Begin the episodes that enter."""
        fresh = engine.begin(arena, policy, key, parameters)
        return jax.tree.map(lambda new, old: jnp.where(entering, new, old), fresh, episode)

    def advance(episode: Episode, parameters: Parameters) -> tuple[Episode, jax.Array]:
        episode = engine.advance(episode, parameters, periods)
        return episode, episodes.over(episode, parameters)

    def lower(function: Any, *arguments: Any, **options: Any) -> Any:
        specs = (*map(_specs, arguments), P())
        results = _specs(jax.eval_shape(function, *arguments, parameters))
        local = jax.shard_map(function, mesh=mesh, in_specs=specs, out_specs=results, check_vma=False)
        placed = jax.tree.map(partial(NamedSharding, mesh), results)
        program = jax.jit(local, out_shardings=placed, compiler_options=compiler_options, **options)
        return program.lower(*jax.tree.map(partial(_described, mesh), arguments), parameters)

    episode = _episode(given, parameters)
    entering = jax.ShapeDtypeStruct(given[2].shape[-1:], bool)
    lowered = [
        lower(refill, episode, *given, entering, donate_argnums=0),
        lower(advance, episode, donate_argnums=0),
        lower(engine.result, episode),
    ]
    with ThreadPoolExecutor() as pool:
        return list(pool.map(lambda program: program.compile(), lowered))


def _described(mesh: Mesh, leaf: Any) -> jax.ShapeDtypeStruct:
    """What the compiler must know of an array that is split along its last axis."""
    return jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=NamedSharding(mesh, _specs(leaf)))
