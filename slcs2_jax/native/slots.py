"""Slots whose episodes the native chunk computes: in the host's own memory, without XLA.

A slot's episode is a column of the arrays, and so are the values that it is computed with: they may differ from slot to
slot, and what decides sizes or code may not. A lane group is a stretch of `library.lanes()` columns; one without an
episode costs nothing, one with few lanes in use more than its share. So before every chunk the episodes are moved
together into few groups, of one size, as many for each thread. That is no more than copying: it changes no bit.
"""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from slcs2_jax.episode import Episode, Parameters, Result
from slcs2_jax.native import advance as native
from slcs2_jax.native import library
from slcs2_jax.world.arena import Arena


def groups_for(episodes: int, threads: int, lanes: int) -> int:
    """Into how many lane groups to put so many episodes: as many for each thread, half full at least.

    With k of 8 lanes a group takes about 5 + k parts of time, so to take the second half apart saves a third of it on
    an idle thread, but costs a third more in all; to take less apart pays less.
    """
    half = max(1, lanes // 2)
    if episodes <= threads * half:
        return -(-episodes // half)
    return threads * -(-episodes // (threads * lanes))


class NativeSlots:
    """A fixed number of slots, and the episodes in them."""

    def __init__(self, parameters: Parameters, arena: Arena, given: Any, *, periods: int, threads: int) -> None:
        """Vacant slots.

        Args:
            parameters: of every episode that brings none of its own.
            arena, given: of vacant slots, without time: NumPy arrays [..., slots].
            periods: sharing periods in a chunk.
            threads: that share the lane groups.
        """
        self._parameters: Parameters = jax.tree.map(np.asarray, parameters)
        self._periods, self._threads, self._lanes = periods, threads, library.lanes()
        self.computed = 0  # slots that the last chunk was computed for: whole groups
        slots = arena.time_limit.shape[0]
        self._columns = np.full(slots, -1)  # of each slot, -1 if it is vacant
        self._entering: dict[int, tuple[Episode, Parameters]] = {}
        vacant = self._begin(arena, given, np.zeros((2, slots), np.uint32), self._parameters)
        self._episode: Episode = jax.tree.map(lambda leaf: np.array(leaf, order="C"), vacant)  # each its own memory
        self._values: Parameters = jax.tree.map(
            lambda leaf: np.repeat(leaf[..., None], slots, axis=-1), self._parameters
        )

    @property
    def held_bytes(self) -> int:
        """Of the arrays that episodes are in."""
        return sum(leaf.nbytes for leaf in jax.tree.leaves(self._held))

    def room(self, certain: int) -> int:
        """How many slots there are in one lane group for each thread, or in as many more as so many episodes need.

        Further groups would cost as much as they bring.
        """
        each = self._threads * self._lanes
        return min(len(self._columns), each * max(1, -(-certain // each)))

    def place(
        self,
        slot: int,
        arena: Arena,
        given: Any,
        key: tuple[np.uint32, np.uint32],
        parameters: Parameters | None = None,
    ) -> None:
        """Let an episode begin with the next chunk.

        Args:
            slot: a vacant one.
            arena: [..., 1].
            given: without a batch axis.
            key: of the episode.
            parameters: with other values than those of the slots, NumPy arrays; all else is the same.
        """
        given = jax.tree.map(lambda leaf: leaf[..., None], given)
        parameters = parameters or self._parameters
        episode = self._begin(arena, given, np.array(key, np.uint32)[:, None], parameters)
        self._entering[slot] = episode, jax.tree.map(lambda leaf: leaf[..., None], parameters)

    def cancel(self, slot: int) -> None:
        """Make a slot vacant."""
        self._entering.pop(slot, None)
        if self._columns[slot] >= 0:
            self._episode.arena.time_limit[self._columns[slot]] = 0
            self._columns[slot] = -1

    def advance(self) -> list[int]:
        """Compute a chunk; returns the slots whose episodes are over."""
        self._gather()
        self.computed = self._lanes * len(np.unique(self._columns[self._columns >= 0] // self._lanes))
        if not self.computed:
            return []
        native.advance_in_place(self._episode, self._values, self._periods, self._threads)
        state, packets = self._episode.state, self._values.physics.swarm.packets
        going = (state.settled < packets) & (state.t < self._episode.arena.time_limit)
        return [int(slot) for slot in np.flatnonzero(self._columns >= 0) if not going[self._columns[slot]]]

    def results(self, slots: list[int]) -> Result:
        """What the episodes in these slots came to, [..., slots]; the slots are vacant then."""
        columns = self._columns[slots]
        ended, values = jax.tree.map(lambda leaf: np.ascontiguousarray(leaf[..., columns]), self._held)
        for slot in slots:
            self.cancel(slot)
        return native.result(ended, values)

    @staticmethod
    def _begin(arena: Arena, given: Any, key: Any, parameters: Parameters) -> Episode:
        return native.begin(arena, given, key, parameters)

    @property
    def _held(self) -> tuple[Episode, Parameters]:
        """What columns hold."""
        return self._episode, self._values

    def _gather(self) -> None:
        """Give those that enter a column, and move others so that groups are few and of one size."""
        lanes, groups = self._lanes, -(-len(self._columns) // self._lanes)
        entering = list(self._entering)
        staying = np.flatnonzero(self._columns >= 0)
        count = len(staying) + len(entering)
        many = min(groups, groups_for(count, self._threads, lanes))
        loads = np.bincount(self._columns[staying] // lanes, minlength=groups)
        order = np.argsort(-loads, kind="stable")  # the fullest groups stay
        target = np.zeros(groups, int)
        target[order[:many]] = [count // many + (place < count % many) for place in range(many)]
        moving = [
            slot
            for group in np.flatnonzero(loads > target)
            for slot in staying[self._columns[staying] // lanes == group][target[group] :]
        ]
        taken = set(self._columns[staying].tolist())
        free = [
            column
            for group in np.flatnonzero(loads < target)
            for column in [c for c in range(group * lanes, (group + 1) * lanes) if c not in taken][
                : target[group] - loads[group]
            ]
        ]
        for slot, column in zip([*moving, *entering], free, strict=True):
            self._put(slot, column)

    def _put(self, slot: int, column: int) -> None:
        """Write the episode that enters, or the one that moves, into a column."""
        before = self._columns[slot]
        entering = self._entering.pop(slot, None)
        if entering is not None:
            jax.tree.map(lambda table, one: table.__setitem__((..., column), one[..., 0]), self._held, entering)
        else:
            jax.tree.map(lambda table: table.__setitem__((..., column), table[..., before]), self._held)
            self._episode.arena.time_limit[before] = 0
        self._columns[slot] = column
