"""What a search holds, as arrays and JSON-able values, and back. m = how many; [n, R] = agents, rules."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from slcs2_jax.grammar.vocabulary import MASK_WORDS
from slcs2_jax.results.figures import Figures
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.member import Member
from slcs2_jax.search.protocol import SearchState
from slcs2_jax.search.solution import ORIGIN, Solution

_SOLUTION: dict[str, tuple[type, tuple[int, ...]]] = {
    "mask": (np.uint32, (MASK_WORDS,)),
    "action": (np.uint8, ()),
    **{name: (dtype, ()) for name, dtype in ORIGIN.items()},
}


def pack_solutions(solutions: list[Solution], shape: tuple[int, int]) -> dict[str, np.ndarray]:
    """Arrays [m, n, R, ...] by field name; generation and parent int64[m]."""
    rows = [solution.arrays() for solution in solutions]
    arrays = {
        name: np.stack([row[name] for row in rows]) if rows else np.empty((0, *shape, *tail), dtype)
        for name, (dtype, tail) in _SOLUTION.items()
    }
    arrays["generation"] = np.array([solution.generation for solution in solutions], np.int64)
    arrays["parent"] = np.array([solution.parent for solution in solutions], np.int64)
    return arrays


def unpack_solutions(arrays: Mapping[str, np.ndarray]) -> list[Solution]:
    """The solutions that pack_solutions was given."""
    generations, parents = arrays["generation"].tolist(), arrays["parent"].tolist()
    return [
        Solution.of({name: arrays[name][place].copy() for name in _SOLUTION}, generation=generation, parent=parent)
        for place, (generation, parent) in enumerate(zip(generations, parents, strict=True))
    ]


def pack_members(members: list[Member]) -> dict[str, np.ndarray]:
    """The members as they are kept, one behind the other: data uint8, length int64[m, 2], explorations int64[m]."""
    pieces = [member.data for member in members]
    return {
        "data": np.frombuffer(b"".join(piece for pair in pieces for piece in pair), np.uint8),
        "length": np.array([[len(piece) for piece in pair] for pair in pieces], np.int64).reshape(-1, 2),
        "explorations": np.array([member.explorations for member in members], np.int64),
    }


def unpack_members(arrays: Mapping[str, np.ndarray]) -> list[Member]:
    """The members that pack_members was given. For what it raises on other arrays see `Compressed.of_data`."""
    data, members, start = arrays["data"].tobytes(), [], 0
    for (first, second), explorations in zip(arrays["length"].tolist(), arrays["explorations"].tolist(), strict=True):
        middle, end = start + first, start + first + second
        members.append(Member.of_data(data[start:middle], data[middle:end], explorations))
        start = end
    return members


def pack_deployments(held: Mapping[tuple[int, int], Deployment], shape: tuple[int, int]) -> dict[str, np.ndarray]:
    """The arrays of deployments of solutions with rules, by generation and number, in their order."""
    order = [held[index] for index in sorted(held)]
    contributions = [deployment.contribution for deployment in order]
    return {
        "index": np.array(sorted(held), np.int64).reshape(-1, 2),
        "fitness": np.array([deployment.fitness for deployment in order], np.float64),
        "delivered": np.array([deployment.delivered for deployment in order], np.int64),
        "steps": np.array([deployment.steps for deployment in order], np.int64),
        "contribution": np.stack(contributions) if order else np.empty((0, shape[0]), np.int32),
        **Figures.stacked([deployment.figures for deployment in order if deployment.figures is not None], shape),
    }


def unpack_deployments(arrays: Mapping[str, np.ndarray]) -> dict[tuple[int, int], Deployment]:
    """The deployments that pack_deployments was given."""
    return {
        (generation, index): Deployment(
            fitness=float(arrays["fitness"][place]),
            delivered=int(arrays["delivered"][place]),
            steps=int(arrays["steps"][place]),
            contribution=arrays["contribution"][place].copy(),
            figures=Figures.taken(arrays, place),
        )
        for place, (generation, index) in enumerate(arrays["index"].tolist())
    }


def pack_state(state: SearchState, shape: tuple[int, int]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A search's state for a file. The best is stored with the members, behind them if it is none."""
    place = next((place for place, member in enumerate(state.members) if member is state.best), None)
    held = state.members if place is not None or state.best is None else [*state.members, state.best]
    arrays = {f"own.{name}": array for name, array in state.arrays.items()}
    arrays |= {f"members.{name}": array for name, array in pack_members(held).items()}
    arrays |= {f"asked.{name}": array for name, array in pack_solutions(state.asked, shape).items()}
    best = None if state.best is None else (len(state.members) if place is None else place)
    return arrays, {"generation": state.generation, "members": len(state.members), "best": best, "own": state.meta}


def unpack_state(arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]) -> SearchState:
    """The state that pack_state was given."""
    members, best = unpack_held(arrays, meta)
    return SearchState(
        generation=int(meta["generation"]),
        members=members,
        best=best,
        asked=unpack_solutions(part_of(arrays, "asked")),
        arrays=part_of(arrays, "own"),
        meta=dict(meta["own"]),
    )


def unpack_held(arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]) -> tuple[list[Member], Member | None]:
    """Members and best of the state that pack_state was given."""
    held = unpack_members(part_of(arrays, "members"))
    return held[: meta["members"]], None if meta["best"] is None else held[meta["best"]]


def part_of(arrays: Mapping[str, np.ndarray], part: str) -> dict[str, np.ndarray]:
    """The arrays whose names begin with `part.`, by the rest of their names."""
    return {name[len(part) + 1 :]: array for name, array in arrays.items() if name.startswith(f"{part}.")}
