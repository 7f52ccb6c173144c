"""A solution: one rule-set per agent, with every rule's origin. [n, R] = agents, rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.vocabulary import PAPER, Vocabulary
from slcs2_jax.search.supply import RuleSupply


class Origin(IntEnum):
    """How a rule came into the rule-set that holds it (a kept rule keeps the origin it had)."""

    INITIAL = 0  # random, in the first solution
    RANDOM = 1  # random, in a later solution
    COPIED = 2  # taken over from another agent's rule-set of the parent solution


ORIGIN = {"origin_kind": np.uint8, "origin_generation": np.int32, "origin_agent": np.int8}
_EXTRAS = ("reflex", "quality")  # of rule-sets, where they have them


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
    def of(cls, values: Mapping[str, Any], vocabulary: Vocabulary = PAPER) -> Solution:
        """The solution whose `values` these are."""
        extras = {name: values[name] for name in _EXTRAS if name in values}
        rules = RuleSets(values["mask"], values["action"], vocabulary, **extras)
        origin = {name: values[name] for name in ORIGIN}
        return cls(rules=rules, **origin, generation=values["generation"], parent=values["parent"])

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
        rules = [array for name, array in self.arrays().items() if name not in ORIGIN]
        return all(bool((array == array[:1]).all()) for array in rules)

    def arrays(self) -> dict[str, np.ndarray]:
        """The per-rule arrays by name: mask, action, where they are there reflex and quality, and origins."""
        arrays: dict[str, np.ndarray] = {"mask": self.rules.mask, "action": self.rules.action}
        arrays |= {name: array for name in _EXTRAS if (array := getattr(self.rules, name)) is not None}
        return arrays | {name: getattr(self, name) for name in ORIGIN}

    def values(self) -> dict[str, Any]:
        """Everything but the vocabulary, as arrays and numbers."""
        return self.arrays() | {"generation": self.generation, "parent": self.parent}

    def equals(self, other: Solution) -> bool:
        """True iff every value is the same (arrays element by element)."""
        mine, its = self.values(), other.values()
        return mine.keys() == its.keys() and all(np.array_equal(mine[name], its[name]) for name in mine)


def random_rules(
    agents: int, rules: int, supply: RuleSupply, vocabulary: Vocabulary = PAPER, others: frozenset[int] | None = None
) -> RuleSets:
    """`agents` rule-sets of `rules` random rules each (paper, Rule Generation).

    With the identities of `others`, each rule-set has none of these, and none of its own twice (`rules.distinct`).
    """
    if others is None:
        drawn = supply.take(agents * rules)
    else:
        sets = [supply.take_distinct(rules, others) for _ in range(agents)]
        drawn = {name: np.concatenate([one[name] for one in sets]) for name in sets[0]}
    return RuleSets(drawn["mask"].reshape(agents, rules, -1), drawn["action"].reshape(agents, rules), vocabulary)
