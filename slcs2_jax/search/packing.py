"""Solutions, members and deployments as arrays, and back. m = how many; [n, R] as elsewhere."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.member import Member
from slcs2_jax.search.solution import Solution

_SOLUTION = {
    "mask": (np.uint32, (1,)),
    "action": (np.uint8, ()),
    "origin_kind": (np.uint8, ()),
    "origin_generation": (np.int32, ()),
    "origin_agent": (np.int8, ()),
}
_MEASURED = ("quality", "strength", "error", "usage")


def _stack(rows: list[np.ndarray], shape: tuple[int, ...], dtype: type) -> np.ndarray:
    return np.stack(rows) if rows else np.empty((0, *shape), dtype)


def pack_solutions(solutions: list[Solution], shape: tuple[int, int]) -> dict[str, np.ndarray]:
    """Arrays [m, n, R, ...] by field name; generation and parent int64[m]."""
    arrays = {
        name: _stack([getattr(one, name) for one in solutions], (*shape, *tail), dtype)
        for name, (dtype, tail) in _SOLUTION.items()
    }
    arrays["generation"] = np.array([one.generation for one in solutions], np.int64)
    arrays["parent"] = np.array([one.parent for one in solutions], np.int64)
    return arrays


def unpack_solutions(arrays: dict[str, np.ndarray]) -> list[Solution]:
    """The solutions that pack_solutions was given."""
    generations, parents = arrays["generation"].tolist(), arrays["parent"].tolist()
    solutions = []
    for place, (generation, parent) in enumerate(zip(generations, parents, strict=True)):
        one = {name: arrays[name][place].copy() for name in _SOLUTION}
        solutions.append(Solution(**one, generation=generation, parent=parent))
    return solutions


def pack_members(members: list[Member]) -> dict[str, np.ndarray]:
    """The members as they are kept, one behind the other: data uint8, length int64[m, 2], explorations int64[m]."""
    pieces = [member.data for member in members]
    return {
        "data": np.frombuffer(b"".join(piece for pair in pieces for piece in pair), np.uint8),
        "length": np.array([[len(piece) for piece in pair] for pair in pieces], np.int64).reshape(-1, 2),
        "explorations": np.array([member.explorations for member in members], np.int64),
    }


def unpack_members(arrays: dict[str, np.ndarray]) -> list[Member]:
    """The members that pack_members was given. What it raises for other arrays, see `Compressed`."""
    data, members, start = arrays["data"].tobytes(), [], 0
    for (one, other), explorations in zip(arrays["length"].tolist(), arrays["explorations"].tolist(), strict=True):
        middle, end = start + one, start + one + other
        members.append(Member.of_data(data[start:middle], data[middle:end], explorations))
        start = end
    return members


def pack_deployments(held: Mapping[int, Deployment], shape: tuple[int, int]) -> dict[str, np.ndarray]:
    """The arrays of deployments by number, in the order of their numbers."""
    order = sorted(held)
    arrays = {
        "index": np.array(order, np.int64),
        "fitness": np.array([held[index].fitness for index in order], np.float64),
        "delivered": np.array([held[index].delivered for index in order], np.int64),
        "steps": np.array([held[index].steps for index in order], np.int64),
        "contribution": _stack([held[index].contribution for index in order], shape[:1], np.int32),
    }
    for name in _MEASURED:
        dtype = np.int32 if name == "usage" else np.float32
        arrays[name] = _stack([getattr(held[index], name) for index in order], shape, dtype)
    return arrays


def unpack_deployments(arrays: Mapping[str, np.ndarray]) -> dict[int, Deployment]:
    """The deployments that pack_deployments was given."""
    return {
        int(index): Deployment(
            fitness=float(arrays["fitness"][place]),
            delivered=int(arrays["delivered"][place]),
            steps=int(arrays["steps"][place]),
            contribution=arrays["contribution"][place].copy(),
            **{name: arrays[name][place].copy() for name in _MEASURED},
        )
        for place, index in enumerate(arrays["index"].tolist())
    }
