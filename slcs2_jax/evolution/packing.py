"""Solutions and members as stacked arrays, and back. m = how many; [n, R] as elsewhere. Rule ids are computed anew."""

from __future__ import annotations

import numpy as np

from slcs2_jax.evolution.evaluation import Evaluation
from slcs2_jax.evolution.member import Member
from slcs2_jax.evolution.solution import Solution
from slcs2_jax.grammar import rule_ids
from slcs2_jax.grammar.vocabulary import MASK_WORDS

_SOLUTION = {
    "mask": (np.uint32, (MASK_WORDS,)),
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
        ids = rule_ids(one["mask"], one["action"])
        solutions.append(Solution(**one, ids=ids, generation=generation, parent=parent))
    return solutions


def pack_members(members: list[Member], shape: tuple[int, int]) -> dict[str, np.ndarray]:
    """The arrays of solutions and evaluations; fitnesses float64[m, most deployments], NaN beyond the last."""
    arrays = pack_solutions([member.solution for member in members], shape)
    evaluations = [member.evaluation for member in members]
    width = max((one.deployments for one in evaluations), default=0)
    fitnesses = np.full((len(members), width), np.nan)
    for row, one in zip(fitnesses, evaluations, strict=True):
        row[: one.deployments] = one.fitnesses
    arrays["fitnesses"] = fitnesses
    arrays["delivered"] = np.array([one.delivered for one in evaluations], np.float64)
    arrays["steps"] = np.array([one.steps for one in evaluations], np.float64)
    arrays["contribution_sum"] = _stack([one.contribution_sum for one in evaluations], shape[:1], np.int64)
    for name in _MEASURED:
        arrays[name] = _stack([getattr(one, name) for one in evaluations], shape, np.float32)
    arrays["explorations"] = np.array([member.explorations for member in members], np.int64)
    return arrays


def unpack_members(arrays: dict[str, np.ndarray]) -> list[Member]:
    """The members that pack_members was given."""
    members = []
    for place, solution in enumerate(unpack_solutions(arrays)):
        fitnesses = arrays["fitnesses"][place]
        evaluation = Evaluation(
            fitnesses=tuple(fitnesses[~np.isnan(fitnesses)].tolist()),
            delivered=float(arrays["delivered"][place]),
            steps=float(arrays["steps"][place]),
            contribution_sum=arrays["contribution_sum"][place].copy(),
            **{name: arrays[name][place].copy() for name in _MEASURED},
        )
        members.append(Member(solution, evaluation, int(arrays["explorations"][place])))
    return members
