"""What a search is: it is asked for solutions and told what they came to, until it is finished.

A search is registered under a name, `@slcs2_jax.register("search", "mine")`, named by `search.name`, and made for each
instance by calling it with a `Problem`. `BaseSearch` does what most searches have in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from slcs2_jax.search.evaluation import Deployment, Evaluation
from slcs2_jax.search.member import Member
from slcs2_jax.search.parts import Verdict
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.solution import Solution


@dataclass(kw_only=True)
class SearchState:
    """Everything a search needs to go on exactly, before or after `ask`.

    generation: solutions told. members, best: the search's own, `best` the same object if it is one of them. asked:
    solutions that were asked for and not told yet. arrays, meta: the rest, `meta` JSON-able.
    """

    generation: int
    members: list[Member]
    best: Member | None
    asked: list[Solution]
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    meta: dict[str, Any] = field(default_factory=dict)


class Trial(Protocol):
    """A solution's evaluation under way. What counts must not depend on the order in which deployments arrive."""

    @property
    def complete(self) -> bool:
        """Is it decided which deployments count, and are all of them here?"""
        ...

    @property
    def held(self) -> dict[int, Deployment]:
        """Those handed in so far, by number."""
        ...

    def wanted(self, ahead: int = 0) -> list[int]:
        """Numbers not handed in yet: those certain to count, and up to `ahead` more that may."""
        ...

    def add(self, index: int, deployment: Deployment) -> None:
        """Hand in a deployment."""
        ...

    def result(self) -> Evaluation:
        """The means over the deployments that count, once it is complete."""
        ...


class Search(Protocol):
    """One instance's search. What it does must follow from its `Problem` and what it is told alone.

    Solutions are numbered in the order asked for: the first `generation` is 0. Each is one generation and one row of
    generations.jsonl.
    """

    @property
    def generation(self) -> int:
        """How many solutions it was told of."""
        ...

    @property
    def finished(self) -> bool:
        """Will it ask for no more? Asked only while no solution is under evaluation."""
        ...

    @property
    def best(self) -> Member:
        """The solution that it would choose now; the winner once it is finished. InputError before the first."""
        ...

    @property
    def members(self) -> list[Member]:
        """The solutions that it holds on to, oldest first; saved when the run ends."""
        ...

    def ask(self, count: int = 1) -> list[Solution]:
        """At most `count` solutions, at least one, to be evaluated side by side. The same ones until they are told."""
        ...

    def trial(self, solution: Solution) -> Trial:
        """An empty evaluation of a solution asked for: it decides how often the solution is deployed."""
        ...

    def tell(self, solutions: Sequence[Solution], evaluations: Sequence[Evaluation]) -> list[Verdict]:
        """What the solutions asked for came to, all of them, in order; what became of each."""
        ...

    def state(self) -> SearchState:
        """Everything needed to go on exactly."""
        ...

    def restore(self, state: SearchState) -> None:
        """Become the search that `state` was taken from, of the same problem; more generations are allowed."""
        ...


class MakeSearch(Protocol):
    """A search's class, or any function that makes one."""

    def __call__(self, problem: Problem, /) -> Search: ...
