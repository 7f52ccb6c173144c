"""The paper's search: a new solution per generation, made from one of those held on to (paper, Behaviour Evolution)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from slcs2_jax.config.registry import KINDS
from slcs2_jax.search.base import BaseSearch
from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.homogeneous import for_all, pooled, shared_rules
from slcs2_jax.search.inheritance import learnt_quality
from slcs2_jax.search.member import Member
from slcs2_jax.search.parts import Acceptance, ParentChoice, Variation, Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.reflexes import mutate_flags, with_flags
from slcs2_jax.search.solution import Solution

if TYPE_CHECKING:
    from slcs2_jax.config import Search as SearchSettings


def check_parts(settings: SearchSettings) -> None:
    """Raise InputError unless the search that the settings name and its parts exist."""
    KINDS["search"].get(settings.name)
    for kind in ("acceptance", "parent", "variation"):
        KINDS[kind].get(getattr(settings, kind))


class Slcs2(BaseSearch):
    """Acceptance, parent choice and variation, each the paper's or another by name (`parts`).

    Asked for several solutions at once (`search.batch`) it chooses parents and makes offspring one after the other, all
    from the same members; they are considered in their order when all are evaluated. One at a time is the paper's.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        settings = problem.settings
        self._acceptance: Acceptance = KINDS["acceptance"].get(settings.acceptance)(problem)
        self._choose: ParentChoice = KINDS["parent"].get(settings.parent)(problem)
        self._vary: Variation = KINDS["variation"].get(settings.variation)(problem)
        self._explorations: dict[int, int] = {}  # of the solutions asked for: phi of the parent before that attempt

    @property
    def members(self) -> list[Member]:
        """The solutions under exploration, oldest first."""
        return self._acceptance.members()

    def propose(self, generation: int) -> Solution:
        """Random rules while there is nothing to start from, then the child of a member; counts the exploration.

        Where knowledge is reflexes, flags of every child change a little; in some nothing else does (`knowledge`)."""
        members = self.members
        if not members or generation < self.settings.starts:
            return self.problem.random_solution(self.supply, generation)
        member = self._choose(members, self.rng)
        self._explorations[generation], member.explorations = member.explorations, member.explorations + 1
        parent, evaluation = member.solution, member.evaluation
        if self.settings.homogeneous:
            parent, evaluation = shared_rules(parent), pooled(evaluation)
        knowledge = self.problem.knowledge
        flags = None if knowledge is None or not knowledge.reflex else parent.rules.reflex
        if knowledge is not None and flags is not None and self.rng.random() < knowledge.alone:
            child = self._unvaried(parent, evaluation, generation)
        else:
            child = self._vary(
                parent,
                evaluation,
                explorations=self._explorations[generation],
                generation=generation,
                members=members,
                supply=self.supply,
                rng=self.rng,
            )
        if knowledge is not None and flags is not None:
            child = with_flags(child, mutate_flags(flags[:, : knowledge.count], self.rng))
        return for_all(child, self.problem.agents) if self.settings.homogeneous else child

    def _unvaried(self, parent: Solution, evaluation: Evaluation, generation: int) -> Solution:
        """The parent again, with what it had learnt if quality is inherited."""
        values = parent.values() | {"generation": generation, "parent": parent.generation}
        if self.settings.inherit_quality:
            values["quality"] = learnt_quality(parent.rules, evaluation, self.problem.initial_quality)
        return Solution.of(values, parent.rules.vocabulary)

    def consider(self, newcomer: Member) -> Verdict:
        """What the acceptance says."""
        explorations = self._explorations.pop(newcomer.generation, 0)
        return replace(self._acceptance.consider(newcomer), explorations=explorations)

    def remember(self) -> dict[str, Any]:
        """The acceptance's counters, and the explorations of the parents of what was asked for."""
        explorations = {str(generation): count for generation, count in self._explorations.items()}
        return {"acceptance": self._acceptance.state(), "explorations": explorations}

    def recall(self, members: list[Member], kept: dict[str, Any]) -> None:
        """What `remember` gave."""
        self._acceptance.restore(members, kept["acceptance"])
        self._explorations = {int(generation): count for generation, count in kept["explorations"].items()}
