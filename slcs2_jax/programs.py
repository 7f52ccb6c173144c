"""Slots whose episodes XLA computes, spread over one or many devices: compiled programs, and what they keep there."""

from __future__ import annotations

import functools
from collections.abc import Sequence
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
from slcs2_jax.episode import Episode, Parameters, Result
from slcs2_jax.world.arena import Arena

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


class CompiledSlots:
    """A fixed number of slots, and the episodes in them: a chunk is computed for all, whether they have one or not."""

    def __init__(
        self, parameters: Parameters, arena: Arena, given: Any, *, periods: int, devices: Sequence[jax.Device]
    ) -> None:
        """Vacant slots.

        Args:
            parameters: of every episode.
            arena, given: of vacant slots, without time: NumPy arrays [..., slots].
            periods: sharing periods in a chunk.
            devices: each has as many of the slots.
        """
        self.computed = arena.time_limit.shape[0]  # slots that a chunk is computed for
        self._arena, self._policies = arena, given
        self._keys = np.zeros((2, self.computed), np.uint32)
        self._entering = np.zeros(self.computed, bool)
        self._taken = np.zeros(self.computed, bool)
        mesh = Mesh(np.array(devices), (AXIS,))
        self._shard = partial(_place, mesh)
        self._parameters = jax.device_put(parameters, NamedSharding(mesh, P()))
        leaves, structure = jax.tree.flatten((self._given(), self._parameters))
        described = tuple(jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in leaves)
        self._refill, self._advance, self._result = _programs(mesh, periods, structure, described)
        nothing = jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), _episode(self._given(), parameters))
        self._episode = self._refill(
            self._shard(nothing), *self._given(), self._shard(np.ones(self.computed, bool)), self._parameters
        )

    @property
    def compiled(self) -> str:
        """The text of the program for a chunk."""
        return str(self._advance.as_text())

    @property
    def held_bytes(self) -> int:
        """Of the arrays that episodes are in."""
        return sum(leaf.nbytes for leaf in jax.tree.leaves(self._episode))

    def room(self, certain: int) -> int:
        """How many slots there are for the cost of so many episodes: all."""
        return self.computed

    def place(self, slot: int, arena: Arena, given: Any, key: tuple[np.uint32, np.uint32]) -> None:
        """Let an episode begin with the next chunk: arena [..., 1], given without a batch axis."""
        jax.tree.map(partial(_write, slot), self._arena, arena)
        jax.tree.map(lambda table, leaf: table.__setitem__((..., slot), leaf), self._policies, given)
        self._keys[:, slot] = key
        self._entering[slot] = self._taken[slot] = True

    def cancel(self, slot: int) -> None:
        """Make a slot vacant."""
        self._arena.time_limit[slot] = 0
        self._entering[slot], self._taken[slot] = True, False

    def advance(self) -> list[int]:
        """Compute a chunk; returns the slots whose episodes are over."""
        if self._entering.any():
            entering = self._shard(self._entering.copy())
            self._episode = self._refill(self._episode, *self._given(), entering, self._parameters)
            self._entering[:] = False
        self._episode, over = self._advance(self._episode, self._parameters)
        return [int(slot) for slot in np.flatnonzero(np.asarray(over) & self._taken)]

    def results(self, slots: list[int]) -> Result:
        """What the episodes in these slots came to, NumPy arrays [..., slots]; the slots are vacant then."""
        self._taken[slots] = False
        found = jax.device_get(self._result(self._episode, self._parameters))
        return jax.tree.map(lambda leaf: leaf[..., slots], found)

    def _given(self) -> tuple[Arena, Any, jax.Array]:
        """What the host holds for the slots, on the devices. Copied: the host writes into its arrays again."""
        return self._shard(jax.tree.map(np.copy, (self._arena, self._policies, self._keys)))


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
def _programs(mesh: Mesh, periods: int, structure: Any, described: tuple[jax.ShapeDtypeStruct, ...]) -> list[Any]:
    """The compiled programs of a rollout: refill, advance, result; each device works on its own slots.

    They are compiled side by side, since the compiler takes one core for each, and kept for the next rollout of the
    same sizes.
    """
    given, parameters = jax.tree.unflatten(structure, described)
    compiler_options = _COMPILER_OPTIONS.get(mesh.devices.flat[0].platform)

    def refill(
        episode: Episode, arena: Arena, policy: Any, key: jax.Array, entering: jax.Array, parameters: Parameters
    ) -> Episode:
        """Begin the episodes that enter."""
        fresh = episodes.begin(arena, policy, key, parameters)
        return jax.tree.map(lambda new, old: jnp.where(entering, new, old), fresh, episode)

    def advance(episode: Episode, parameters: Parameters) -> tuple[Episode, jax.Array]:
        episode = episodes.advance(episode, parameters, periods)
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
        lower(episodes.result, episode),
    ]
    with ThreadPoolExecutor() as pool:
        return list(pool.map(lambda program: program.compile(), lowered))


def _described(mesh: Mesh, leaf: Any) -> jax.ShapeDtypeStruct:
    """What the compiler must know of an array that is split along its last axis."""
    return jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=NamedSharding(mesh, _specs(leaf)))
