"""Behavioural distance between solutions, Delta b (paper, Solution-Collection update).

Delta b'(X_i, Y_i) of two rule-sets is the share, among the rules of both, of rules that the other rule-set lacks;
Delta b is its mean over the agents, agent i compared with agent i only. A rule held twice counts twice. As every
rule-set has R rules, Delta b = (rules lacked, over all agents) / (2 n R): one division of two whole numbers, the same
on every machine.
"""

from __future__ import annotations

import numpy as np

from slcs2_jax.config import InputError

_U64 = np.uint64


def _agent_constants(agents: int) -> np.ndarray:
    """uint64[agents] constants far from each other (the splitmix64 sequence)."""
    x = np.arange(1, agents + 1, dtype=_U64) * _U64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> _U64(30))) * _U64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> _U64(27))) * _U64(0x94D049BB133111EB)
    return x ^ (x >> _U64(31))


def _keys(ids: np.ndarray, constants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sorted distinct keys uint64[K] of the (agent, rule) pairs in ids [n, R], and how often each occurs int64[K].

    The constants make agents' keys disjoint, but for two agents' rules whose 64-bit ids differ by exactly one pattern:
    no likelier than two different rules having one id.
    """
    key = np.sort((ids ^ constants[:, None]).ravel())
    first = np.concatenate(([True], key[1:] != key[:-1]))
    start = np.flatnonzero(first)
    return key[start], np.diff(start, append=key.size)


def novelty(x: np.ndarray, y: np.ndarray) -> float:
    """Delta b of two solutions, given their rule ids uint64[n, R]: 0 (same rules) to 1 (none in common)."""
    index = NoveltyIndex(*x.shape)
    index.add(y)
    return float(index.distances(x)[0])


class NoveltyIndex:
    """The rules of all members of a collection, sorted, so that one newcomer is compared with all at once.

    An entry is (key of agent and rule, position of the member that holds it, how often it does), sorted by key.
    Cost of a comparison: n R binary searches and one addition per rule shared with a member.
    """

    def __init__(self, agents: int, rules: int) -> None:
        self._shape = (agents, rules)
        self._constants = _agent_constants(agents)
        self._size = 0
        self._key = np.empty(0, np.uint64)
        self._owner = np.empty(0, np.int32)
        self._count = np.empty(0, np.uint16)

    def __len__(self) -> int:
        return self._size

    def _check(self, ids: np.ndarray) -> None:
        if ids.shape != self._shape or ids.dtype != np.uint64:
            raise InputError(f"rule ids are {ids.dtype}{list(ids.shape)}; uint64{list(self._shape)} is expected")

    def distances(self, ids: np.ndarray) -> np.ndarray:
        """float64[members] Delta b of the solution with rule ids uint64[n, R] to every member, in member order."""
        self._check(ids)
        key, count = _keys(ids, self._constants)
        low = np.searchsorted(self._key, key, side="left")
        shared = np.searchsorted(self._key, key, side="right") - low  # members that hold the rule
        ends = np.cumsum(shared)
        entry = np.arange(ends[-1]) + np.repeat(low - ends + shared, shared)
        both = np.repeat(count, shared) + self._count[entry]  # occurrences here and there: lacked by neither
        common = np.bincount(self._owner[entry], weights=both, minlength=self._size)
        total = 2 * ids.size
        return (total - common) / total

    def add(self, ids: np.ndarray) -> None:
        """Append a member."""
        self._check(ids)
        key, count = _keys(ids, self._constants)
        at = np.searchsorted(self._key, key)
        self._key = np.insert(self._key, at, key)
        self._owner = np.insert(self._owner, at, self._size)
        self._count = np.insert(self._count, at, count.astype(np.uint16))
        self._size += 1

    def remove(self, positions: np.ndarray) -> None:
        """Drop the members at these positions; those behind move up."""
        stays = np.ones(self._size, bool)
        stays[positions] = False
        entry = stays[self._owner]
        renumbered = np.cumsum(stays, dtype=np.int32) - 1
        self._key, self._count = self._key[entry], self._count[entry]
        self._owner = renumbered[self._owner[entry]].astype(np.int32)
        self._size = int(stays.sum())
