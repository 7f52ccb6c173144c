"""What a search holds, as arrays and JSON-able values, and back. m = how many; [n, R] = agents, rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.results.figures import Figures
from slcs2_jax.search.compressed import compress, decompress
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.member import Member
from slcs2_jax.search.protocol import SearchState
from slcs2_jax.search.solution import Solution

Packed = dict[str, np.ndarray]


def _pack(pieces: Sequence[Sequence[bytes]], parts: int) -> Packed:
    """Bytes of m records of so many parts, one behind the other: data uint8, length int64[m, parts]."""
    return {
        "data": np.frombuffer(b"".join(piece for record in pieces for piece in record), np.uint8),
        "length": np.array([[len(piece) for piece in record] for record in pieces], np.int64).reshape(-1, parts),
    }


def _unpack(arrays: Mapping[str, np.ndarray]) -> list[list[bytes]]:
    """The records that _pack was given."""
    data, lengths = arrays["data"].tobytes(), arrays["length"]
    ends = np.cumsum(lengths).reshape(lengths.shape)
    if (lengths < 0).any() or (ends.size and ends.flat[-1] != len(data)):
        raise ValueError("its records are not as long as it says")
    pairs = zip((ends - lengths).tolist(), ends.tolist(), strict=True)
    return [[data[start:end] for start, end in zip(*record, strict=True)] for record in pairs]


def pack_solutions(solutions: Sequence[Solution]) -> Packed:
    """Solutions as bytes; see `compress`."""
    return _pack([[compress(solution.values())] for solution in solutions], 1)


def unpack_solutions(arrays: Mapping[str, np.ndarray], vocabulary: Vocabulary) -> list[Solution]:
    """The solutions that pack_solutions was given. For what it raises on other arrays see `decompress`."""
    return [Solution.of(decompress(data), vocabulary) for [data] in _unpack(arrays)]


def pack_members(members: Sequence[Member]) -> Packed:
    """The members as they are kept, and explorations int64[m]."""
    explorations = np.array([member.explorations for member in members], np.int64)
    return _pack([member.data for member in members], 2) | {"explorations": explorations}


def unpack_members(arrays: Mapping[str, np.ndarray], vocabulary: Vocabulary) -> list[Member]:
    """The members that pack_members was given. For what it raises on other arrays see `decompress`."""
    pairs = zip(_unpack(arrays), arrays["explorations"].tolist(), strict=True)
    return [Member.of_data(solution, evaluation, count, vocabulary) for (solution, evaluation), count in pairs]


def pack_deployments(held: Mapping[tuple[int, int], Deployment], shape: tuple[int, int]) -> Packed:
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


def pack_state(state: SearchState) -> tuple[Packed, dict[str, Any]]:
    """A search's state for a file. The best is stored with the members, behind them if it is none."""
    place = next((place for place, member in enumerate(state.members) if member is state.best), None)
    held = state.members if place is not None or state.best is None else [*state.members, state.best]
    arrays = {f"own.{name}": array for name, array in state.arrays.items()}
    arrays |= {f"members.{name}": array for name, array in pack_members(held).items()}
    arrays |= {f"asked.{name}": array for name, array in pack_solutions(state.asked).items()}
    best = None if state.best is None else (len(state.members) if place is None else place)
    return arrays, {"generation": state.generation, "members": len(state.members), "best": best, "own": state.meta}


def unpack_state(arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any], vocabulary: Vocabulary) -> SearchState:
    """The state that pack_state was given."""
    members, best = unpack_held(arrays, meta, vocabulary)
    return SearchState(
        generation=int(meta["generation"]),
        members=members,
        best=best,
        asked=unpack_solutions(part_of(arrays, "asked"), vocabulary),
        arrays=part_of(arrays, "own"),
        meta=dict(meta["own"]),
    )


def unpack_held(
    arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any], vocabulary: Vocabulary
) -> tuple[list[Member], Member | None]:
    """Members and best of the state that pack_state was given."""
    held = unpack_members(part_of(arrays, "members"), vocabulary)
    return held[: meta["members"]], None if meta["best"] is None else held[meta["best"]]


def part_of(arrays: Mapping[str, np.ndarray], part: str) -> dict[str, np.ndarray]:
    """The arrays whose names begin with `part.`, by the rest of their names."""
    return {name[len(part) + 1 :]: array for name, array in arrays.items() if name.startswith(f"{part}.")}
