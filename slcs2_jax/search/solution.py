"""A solution: one rule-set per agent, with every rule's origin. [n, R] = agents, rules; masks are 4 words."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.grammar import rule_ids
from slcs2_jax.search.supply import RuleSupply


class Origin(IntEnum):
    """How a rule came into the rule-set that holds it (a kept rule keeps the origin it had)."""

    INITIAL = 0  # random, in the first solution
    RANDOM = 1  # random, in a later solution
    COPIED = 2  # taken over from another agent's rule-set of the parent solution


_RULE_ARRAYS = {
    "mask": np.uint32,
    "action": np.uint8,
    "origin_kind": np.uint8,
    "origin_generation": np.int32,
    "origin_agent": np.int8,
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """An ordered set of rule-sets, one per agent. A run makes one solution per generation, so `generation` names it.

    The arrays are made read-only: members of a collection share no state that anyone can change.
    """

    mask: np.ndarray  # uint32[n, R, 4] clause masks
    action: np.ndarray  # uint8[n, R] action numbers
    origin_kind: np.ndarray  # uint8[n, R] of Origin
    origin_generation: np.ndarray  # int32[n, R] generation in which the rule got its kind
    origin_agent: np.ndarray  # int8[n, R] agent it was copied from; -1 if it was not
    generation: int  # in which this solution was made, from 0
    parent: int  # generation of the solution it was made from; -1 for the first

    def __post_init__(self) -> None:
        shape = self.action.shape
        if len(shape) != 2:
            raise InputError(f"solution.action has shape {shape}; [agents, rules] is expected")
        for name, dtype in _RULE_ARRAYS.items():
            array = getattr(self, name)
            expected = (*shape, self.mask.shape[-1]) if name == "mask" else shape
            if array.shape != expected or array.dtype != dtype:
                found = f"{array.dtype}{list(array.shape)}"
                raise InputError(f"solution.{name} is {found}; {np.dtype(dtype)}{list(expected)} is expected")
            array.flags.writeable = False

    @property
    def agents(self) -> int:
        return self.action.shape[0]

    @property
    def rules(self) -> int:
        return self.action.shape[1]

    @property
    def ids(self) -> np.ndarray:
        """Rule identities uint64[n, R], computed at each look."""
        return rule_ids(self.mask, self.action)

    def arrays(self) -> dict[str, np.ndarray]:
        """The per-rule arrays by name."""
        return {name: getattr(self, name) for name in _RULE_ARRAYS}

    def equals(self, other: Solution) -> bool:
        """True iff every field is the same (arrays element by element)."""
        return all(np.array_equal(getattr(self, field.name), getattr(other, field.name)) for field in fields(self))


def initial_solution(agents: int, rules: int, supply: RuleSupply) -> Solution:
    """The first solution of a run: `agents` rule-sets of `rules` random rules each (paper, Rule Generation)."""
    shape = (agents, rules)
    drawn = supply.take(agents * rules)
    return Solution(
        mask=drawn["mask"].reshape(*shape, -1),
        action=drawn["action"].reshape(shape),
        origin_kind=np.full(shape, Origin.INITIAL, np.uint8),
        origin_generation=np.zeros(shape, np.int32),
        origin_agent=np.full(shape, -1, np.int8),
        generation=0,
        parent=-1,
    )
