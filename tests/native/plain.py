"""The native calls without XLA: any compiled library, on NumPy arrays."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import jax
import numpy as np

from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.native.arrays import MOST_KEPT, Sizes, given_arrays, kept_arrays, notes_shapes, with_kept

GIVEN, KEPT, NOTED = 29, MOST_KEPT, 18


class Plain:
    """A library's calls."""

    def __init__(self, path: Path | str) -> None:
        self._library = ctypes.CDLL(str(path))
        self.lanes: int = self._library.slcs2_lanes()

    def advance(
        self, episode: Episode, parameters: Parameters, periods: int, *, noted: bool = False
    ) -> list[np.ndarray]:
        """State and memory of the episodes after so many sharing periods, in the order of ``kept_arrays``."""
        sizes = Sizes.of(episode, parameters, periods, noted=noted)
        return self._call(self._library.slcs2_advance, episode, parameters, sizes)

    def finish(self, episode: Episode, parameters: Parameters) -> list[np.ndarray]:
        """The same with the memory of episodes that are over."""
        return self._call(self._library.slcs2_finish, episode, parameters, Sizes.of(episode, parameters, 0))

    @staticmethod
    def _call(function: Any, episode: Episode, parameters: Parameters, sizes: Sizes) -> list[np.ndarray]:
        given = [np.ascontiguousarray(array) for array in given_arrays(episode, parameters)]
        kept = [np.array(array, order="C") for array in kept_arrays(episode)]
        assert len(given) == GIVEN
        pointers = (ctypes.c_void_p * (GIVEN + KEPT + NOTED))()
        for place, array in enumerate([*given, *kept]):
            pointers[place] = array.ctypes.data
        shapes = notes_shapes(sizes) if sizes.noted else {}
        notes = [np.zeros(one.shape, one.dtype) for one in shapes.values()]
        for place, array in enumerate(notes):
            pointers[GIVEN + KEPT + place] = array.ctypes.data
        assert function(sizes.as_array().ctypes.data_as(ctypes.c_void_p), pointers, 2) == 0
        return kept


def some(episode: Episode, columns: Any) -> Episode:
    """Some episodes of a batch, in this order."""
    return jax.tree.map(lambda leaf: leaf[..., columns], episode)


def joined(kept: list[np.ndarray], episode: Episode) -> Episode:
    """The episodes with what a call left of their state and memory."""
    return with_kept(episode, kept)
