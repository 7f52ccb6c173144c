"""Members: evaluated solutions that a search holds on to."""

from __future__ import annotations

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
        """The member whose `data` this was. For what it raises on other bytes see `Compressed.of_data`."""
        made = cls.__new__(cls)
        made._solution = Compressed.of_data(Solution, solution)
        made._evaluation = Compressed.of_data(Evaluation, evaluation)
        made.explorations = explorations
        made.fitness, made.generation = made.evaluation.fitness, made.solution.generation
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
