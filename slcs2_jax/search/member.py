"""Members: evaluated solutions that a search holds on to."""

from __future__ import annotations

from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.results.figures import FIGURES, Figures
from slcs2_jax.search.compressed import compress, decompress
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
        self._vocabulary = solution.rules.vocabulary
        self.data = compress(solution.values()), compress(_evaluation_values(evaluation))  # as they are kept

    @classmethod
    def of_data(cls, solution: bytes, evaluation: bytes, explorations: int, vocabulary: Vocabulary) -> Member:
        """The member whose `data` this was. For what it raises on other bytes see `decompress`."""
        made = cls.__new__(cls)
        made.data, made.explorations, made._vocabulary = (solution, evaluation), explorations, vocabulary
        made.fitness, made.generation = made.evaluation.fitness, made.solution.generation
        return made

    @property
    def solution(self) -> Solution:
        return Solution.of(decompress(self.data[0]), self._vocabulary)

    @property
    def evaluation(self) -> Evaluation:
        values = decompress(self.data[1])
        figures = Figures(**{name: values.pop(name) for name in FIGURES})
        return Evaluation(figures=figures, **values)


def _evaluation_values(evaluation: Evaluation) -> dict[str, object]:
    """An evaluation as plain values."""
    plain = {name: value for name, value in vars(evaluation).items() if name != "figures" and value is not None}
    return plain | evaluation.figures.arrays()
