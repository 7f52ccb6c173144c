"""A solution: one rule-set per agent, with every rule's origin. [n, R] = agents, rules."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.grammar import RuleSets
from slcs2_jax.search.supply import RuleSupply


class Origin(IntEnum):
    """How a rule came into the rule-set that holds it (a kept rule keeps the origin it had)."""

    INITIAL = 0  # random, in the first solution
    RANDOM = 1  # random, in a later solution
    COPIED = 2  # taken over from another agent's rule-set of the parent solution


ORIGIN = {"origin_kind": np.uint8, "origin_generation": np.int32, "origin_agent": np.int8}


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """An ordered set of rule-sets, one per agent. A run makes one solution per generation, so `generation` names it.

    The arrays are made read-only: members of a collection share no state that anyone can change.
    """

    rules: RuleSets
    origin_kind: np.ndarray  # uint8[n, R] of Origin
    origin_generation: np.ndarray  # int32[n, R] generation in which the rule got its kind
    origin_agent: np.ndarray  # int8[n, R] agent it was copied from; -1 if it was not
    generation: int  # in which this solution was made, from 0
    parent: int  # generation of the solution it was made from; -1 for the first

    def __post_init__(self) -> None:
        for name, dtype in ORIGIN.items():
            array = getattr(self, name)
            if array.shape != self.shape or array.dtype != dtype:
                got = f"{array.dtype}{list(array.shape)}"
                raise InputError(f"solution.{name} is {got}; {np.dtype(dtype)}{list(self.shape)} is expected")
        for array in self.arrays().values():
            array.flags.writeable = False

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray], *, generation: int, parent: int) -> Solution:
        """The solution whose `arrays` these are."""
        origin = {name: arrays[name] for name in ORIGIN}
        return cls(rules=RuleSets(arrays["mask"], arrays["action"]), **origin, generation=generation, parent=parent)

    @classmethod
    def made(cls, rules: RuleSets, *, generation: int, parent: int = -1) -> Solution:
        """Rule-sets whose rules all count as new in this generation, for searches that do not trace their origins."""
        shape = rules.action.shape
        return cls(
            rules=rules,
            origin_kind=np.full(shape, Origin.RANDOM if generation else Origin.INITIAL, np.uint8),
            origin_generation=np.full(shape, generation, np.int32),
            origin_agent=np.full(shape, -1, np.int8),
            generation=generation,
            parent=parent,
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Agents and rules."""
        agents, rules = self.rules.action.shape
        return agents, rules

    @property
    def ids(self) -> np.ndarray:
        """Rule identities uint64[n, R], computed at each look."""
        return self.rules.ids()

    @property
    def homogeneous(self) -> bool:
        """Have all agents the same rules in the same places?"""
        return bool(
            (self.rules.action == self.rules.action[:1]).all() and (self.rules.mask == self.rules.mask[:1]).all()
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """The per-rule arrays by name."""
        origin: dict[str, np.ndarray] = {name: getattr(self, name) for name in ORIGIN}
        return {"mask": self.rules.mask, "action": self.rules.action, **origin}

    def equals(self, other: Solution) -> bool:
        """True iff every field is the same (arrays element by element)."""
        own, others = self.arrays(), other.arrays()
        same = all(np.array_equal(own[name], others[name]) for name in own)
        return same and (self.generation, self.parent) == (other.generation, other.parent)


def random_rules(agents: int, rules: int, supply: RuleSupply) -> RuleSets:
    """`agents` rule-sets of `rules` random rules each (paper, Rule Generation)."""
    drawn = supply.take(agents * rules)
    mask, action = drawn["mask"], drawn["action"]
    return RuleSets(mask.reshape(agents, rules, mask.shape[-1]), action.reshape(agents, rules))
