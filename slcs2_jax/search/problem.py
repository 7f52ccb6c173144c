"""What a search is made for: how many agents with how many rules, where random rules come from, and its settings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.config.arguments import whole
from slcs2_jax.grammar.vocabulary import PAPER, Vocabulary
from slcs2_jax.search.homogeneous import for_all
from slcs2_jax.search.keys import PURPOSE_RULES, PURPOSE_SEARCH, seed_sequence
from slcs2_jax.search.knowledge import Knowledge
from slcs2_jax.search.solution import Solution, random_rules
from slcs2_jax.search.supply import RuleSource, RuleSupply

if TYPE_CHECKING:
    from slcs2_jax.config import Search as SearchSettings

MOST_AGENTS, MOST_RULES = 64, 1000


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One instance as a search sees it. Every search, and every part of one, is made with one of these.

    Raises InputError for sizes or a seed that are not accepted.

    Attributes:
        settings: `Settings.search`.
        agents, rules: n and R, of every solution.
        seed: of the instance; all that a search draws follows from it.
        vocabulary: what the numbers of clauses and actions mean.
        knowledge: the designer's rules in the first places of every rule-set; None for none.
        initial_quality: `learning.initial_quality`, of rules that inherit none.
        worlds: W, in which every solution is deployed by turns: deployment i takes place in world i mod W.
        kinds: of these worlds; the first ones are of different kinds.
        distinct: no new rule is twice in a rule-set (`rules.distinct`).
        source: source(count, rng) draws random rules of the grammar, masks uint32[count, W] and actions uint8[count].
    """

    settings: SearchSettings
    agents: int
    rules: int
    seed: int
    source: RuleSource
    vocabulary: Vocabulary = PAPER
    knowledge: Knowledge | None = None
    initial_quality: float = 0.0
    distinct: bool = False
    worlds: int = 1
    kinds: int = 1

    def __post_init__(self) -> None:
        limits = {"agents": (1, MOST_AGENTS), "rules": (1, MOST_RULES), "seed": (0, 2**64 - 1)}
        for name, (low, high) in limits.items():
            object.__setattr__(self, name, whole(name, getattr(self, name), low, high))

    @property
    def shape(self) -> tuple[int, int]:
        """Agents and rules."""
        return self.agents, self.rules

    @property
    def places(self) -> int:
        """K, first places of every rule-set that knowledge has; 0 without."""
        return 0 if self.knowledge is None else self.knowledge.count

    def supply(self) -> RuleSupply:
        """Random rules from their start; the same ones each time."""
        return RuleSupply(self.source, seed_sequence(self.seed, PURPOSE_RULES))

    def rng(self) -> np.random.Generator:
        """The generator of everything else that the search draws, from its start."""
        return np.random.Generator(np.random.PCG64(seed_sequence(self.seed, PURPOSE_SEARCH)))

    def random_solution(self, supply: RuleSupply, generation: int) -> Solution:
        """Random rules for every agent behind those of knowledge; of a homogeneous swarm one rule-set for all."""
        homogeneous = self.settings.homogeneous
        others = None
        if self.distinct:
            known = [] if self.knowledge is None else self.knowledge.rules.ids().ravel().tolist()
            others = frozenset(known)
        drawn = random_rules(1 if homogeneous else self.agents, self.rules, supply, self.vocabulary, others)
        if self.knowledge is not None:
            drawn = self.knowledge.placed(drawn, generation)
        if self.settings.inherit_quality:
            quality = np.full(drawn.action.shape, self.initial_quality, np.float32)
            drawn = replace(drawn, quality=quality)
        solution = Solution.made(drawn, generation=generation)
        return for_all(solution, self.agents) if homogeneous else solution

    def check(self, solution: Solution, generation: int) -> None:
        """Raise InputError unless the solution has these sizes, this generation, and one rule-set if all share one."""
        label = f"search={self.settings.name}: the solution of generation {generation}"
        if not isinstance(solution, Solution):
            raise InputError(f"{label} is a {type(solution).__name__}; accepted is a Solution")
        if solution.shape != self.shape:
            raise InputError(f"{label} has {list(solution.shape)} agents and rules; accepted are {list(self.shape)}")
        if solution.generation != generation:
            raise InputError(f"{label} says that it is that of {solution.generation}; accepted are numbers in order")
        if self.settings.homogeneous and not solution.homogeneous:
            raise InputError(f"{label} has different rule-sets; accepted is one for all (search.homogeneous=true)")
        if self.knowledge is not None and not self.knowledge.stands_in(solution.rules):
            raise InputError(f"{label} lacks rules of knowledge.rules; accepted has them first, and no other reflexes")
        if self.settings.inherit_quality != (solution.rules.quality is not None):
            lacks = "has no" if self.settings.inherit_quality else "has"
            raise InputError(f"{label} {lacks} initial quality; accepted is as search.inherit_quality says")
