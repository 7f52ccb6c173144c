"""What the two kinds of acceptance share: members, verdicts and the interface that the search uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from slcs2_jax.evolution.evaluation import Evaluation
from slcs2_jax.evolution.solution import Solution


@dataclass(eq=False)
class Member:
    """An evaluated solution and how often it was taken as a parent (phi), the one thing about it that changes."""

    solution: Solution
    evaluation: Evaluation
    explorations: int = 0

    @property
    def fitness(self) -> float:
        return self.evaluation.fitness

    @property
    def generation(self) -> int:
        return self.solution.generation


@dataclass(frozen=True)
class Verdict:
    """What became of a newcomer."""

    accepted: bool
    novelty: float  # mean Delta b to the members it met; NaN if it met none
    removed: tuple[int, ...]  # generations of the members that left for it
    size: int  # members afterwards


class Acceptance(Protocol):
    """Decides which evaluated solutions are explored further, and which of them next."""

    def consider(self, newcomer: Member) -> Verdict:
        """Take in or refuse the newcomer."""
        ...

    def parent(self) -> tuple[Member, int]:
        """The member to explore next and its explorations before this one; counts this one."""
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
