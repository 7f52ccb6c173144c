"""The parts of the SLCS2 search that can be replaced by name: acceptance, parent choice, variation.

Each is registered under a name (`slcs2_jax.register("acceptance", "mine")`), named by a setting (`acceptance`,
`search.parent`, `search.variation`) and called with a `Problem` when a search is made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.member import Member
from slcs2_jax.search.solution import Solution
from slcs2_jax.search.supply import RuleSupply


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What became of a newcomer; what a search has no notion of is left out."""

    accepted: bool = True
    novelty: float = float("nan")  # mean Delta b to the members it met; NaN if it met none
    removed: tuple[int, ...] = ()  # generations of the members that left for it
    size: int = 0  # members afterwards
    explorations: int = 0  # phi of its parent before this attempt


class Acceptance(Protocol):
    """Decides which evaluated solutions are explored further."""

    def consider(self, newcomer: Member) -> Verdict:
        """Take in or refuse the newcomer."""
        ...

    def members(self) -> list[Member]:
        """The members held, oldest first."""
        ...

    def state(self) -> dict[str, Any]:
        """Everything but the members, as JSON-able values."""
        ...

    def restore(self, members: list[Member], state: dict[str, Any]) -> None:
        """Become what `members()` and `state()` were taken from."""
        ...


class ParentChoice(Protocol):
    """Says which member is explored next. It keeps nothing from call to call."""

    def __call__(self, members: Sequence[Member], rng: np.random.Generator) -> Member:
        """One of the members, of which there is at least one; they are given oldest first."""
        ...


class Variation(Protocol):
    """Makes a new solution from an evaluated one. It keeps nothing from call to call."""

    def __call__(
        self,
        parent: Solution,
        evaluation: Evaluation,
        *,
        explorations: int,
        generation: int,
        members: Sequence[Member],
        supply: RuleSupply,
        rng: np.random.Generator,
    ) -> Solution:
        """The child of `parent`.

        Args:
            parent, evaluation: the member chosen; of a homogeneous swarm as a swarm of one agent (`homogeneous`).
            explorations: phi of the parent before this attempt.
            generation: that the child is made in.
            members: all that could have been chosen, oldest first.
            supply: new random rules.
            rng: for everything else that is drawn.
        """
        ...
