"""Episodes advanced by the native chunk.

Episodes are of JAX's arrays, inside of compiled programs, or of NumPy's: then the library is called at once, without
XLA, and changes them in place.
"""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from slcs2_jax.episode import Episode, Parameters, Result
from slcs2_jax.native import library
from slcs2_jax.native.arrays import MOST_KEPT, Sizes, given_arrays, kept_arrays, notes_shapes, with_kept
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.policy.policy import Figures
from slcs2_jax.swarm.state import initial_state
from slcs2_jax.swarm.step import failed
from slcs2_jax.world.arena import Arena


def begin(arena: Arena, given: Any, key: jax.Array, parameters: Parameters) -> Episode:
    """``episode.begin``, but that the links of the first step are not drawn yet: ``advance`` does so itself."""
    physics = parameters.physics
    failing = physics.swarm.failures is not None
    state = initial_state(arena, key, physics.swarm.packets, physics.radio.noise, failing=failing)
    if failing:
        state = failed(state, physics.task.running(state, arena, physics.swarm), physics.swarm)
    return Episode(arena, given, state, parameters.policy.initial_memory(given, arena.start_x, parameters.learning))


def advance(episode: Episode, parameters: Parameters, periods: int) -> Episode:
    """``episode.advance`` for a batch of episodes whose axis is the last, by the native chunk.

    Episodes that are over when it begins stay as they are.
    """
    return _call("slcs2_advance", episode, parameters, Sizes.of(episode, parameters, periods))[0]


def advance_in_place(episode: Episode, parameters: Parameters, periods: int, threads: int) -> None:
    """``advance`` for NumPy arrays, C-contiguous and each with memory of its own; lane groups are shared by threads.

    Leaves of the parameters may have the batch as their last axis: each episode its own values.
    """
    _call_in_place("slcs2_advance", episode, parameters, Sizes.of(episode, parameters, periods), threads)


def watch(episode: Episode, parameters: Parameters, periods: int) -> tuple[Episode, dict[str, jax.Array], jax.Array]:
    """``advance``; of the first episode notes of every step; and in how many steps each of its rules held: [R, n]."""
    sizes = Sizes.of(episode, parameters, periods, noted=True)
    episode, notes = _call("slcs2_advance", episode, parameters, sizes)
    matched = notes.pop("matched")
    return episode, notes, matched


def result(episode: Episode, parameters: Parameters) -> Result:
    """``episode.result`` for a batch of episodes, by the native code; those of NumPy arrays are used up.

    Leaves of the parameters may have the batch as their last axis.
    """
    policy, state = parameters.policy, episode.state
    figures: Figures | None
    if type(policy) is Classifier:
        sizes = Sizes.of(episode, parameters, 0)
        if isinstance(state.t, np.ndarray):
            _call_in_place("slcs2_finish", episode, parameters, sizes, threads=1)
        else:
            episode, _ = _call("slcs2_finish", episode, parameters, sizes)
        end = episode.memory
        figures = Figures(quality=end.quality, strength=end.strength, error=end.error, usage=end.usage)
    else:
        figures = policy.finish(episode.memory, state.t, parameters.learning)
    return Result(
        steps=state.t,
        delivered=state.delivered,
        contribution=state.contribution,
        figures=figures,
        measures={},
    )


def _call(name: str, episode: Episode, parameters: Parameters, sizes: Sizes) -> tuple[Episode, dict[str, jax.Array]]:
    given, kept = given_arrays(episode, parameters), kept_arrays(episode)
    notes = notes_shapes(sizes) if sizes.noted else {}
    shapes = [*(jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in kept), *notes.values()]
    aliases = {len(given) + k: k for k in range(len(kept))}
    found = jax.ffi.ffi_call(name, shapes, input_output_aliases=aliases)(*given, *kept, sizes=sizes.as_array())
    return with_kept(episode, found[: len(kept)]), dict(zip(notes, found[len(kept) :], strict=True))


def _call_in_place(name: str, episode: Episode, parameters: Parameters, sizes: Sizes, threads: int) -> None:
    given = [np.ascontiguousarray(array) for array in given_arrays(episode, parameters)]
    kept = kept_arrays(episode)
    nothing = [None] * (MOST_KEPT - len(kept) + len(notes_shapes(sizes)))
    library.call(name, sizes.as_array(), [*given, *kept, *nothing], threads)
