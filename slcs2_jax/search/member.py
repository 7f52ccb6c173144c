"""What the two kinds of acceptance share: members, verdicts and the interface that the search uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from slcs2_jax.search.compressed import Compressed
from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.solution import Solution


class Member:
    """An evaluated solution and how often it was taken as a parent (phi), the one thing about it that changes.

    Collections hold hundreds of them for hundreds of runs at once and look at few, so solution and evaluation are kept
    compressed, and are new objects at each look.
    """

    def __init__(self, solution: Solution, evaluation: Evaluation, explorations: int = 0) -> None:
        self.explorations = explorations
        self.fitness = evaluation.fitness
        self.generation = solution.generation
        self._solution, self._evaluation = Compressed(solution), Compressed(evaluation)

    @classmethod
    def of_data(cls, solution: bytes, evaluation: bytes, explorations: int) -> Member:
        """The member whose `data` this was. What it raises if it was none's, see `Compressed`."""
        made = cls.__new__(cls)
        made._solution = Compressed.of_data(Solution, solution)
        made._evaluation = Compressed.of_data(Evaluation, evaluation)
        made.explorations, made.fitness, made.generation = (
            explorations,
            made.evaluation.fitness,
            made.solution.generation,
        )
        return made

    @property
    def data(self) -> tuple[bytes, bytes]:
        """Solution and evaluation as they are kept."""
        return self._solution.data, self._evaluation.data

    @property
    def solution(self) -> Solution:
        return self._solution.record()

    @property
    def evaluation(self) -> Evaluation:
        return self._evaluation.record()


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
