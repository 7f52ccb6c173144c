"""What the rules of a batch can say: of users' clauses and actions only these are computed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.vocabulary import PAPER, WORD_BITS, Vocabulary


class Sayer(Protocol):
    """What says rules: a grammar, or rules that are there. Numbers of the clauses and actions that it can say."""

    @property
    def vocabulary(self) -> Vocabulary: ...

    @property
    def clauses(self) -> tuple[int, ...]: ...

    @property
    def actions(self) -> tuple[int, ...]: ...

    @property
    def channels_used(self) -> tuple[int, ...]: ...


@dataclass(frozen=True)
class Language:
    """A vocabulary, how many words of a mask can be needed, and which users' clauses and actions can come up."""

    vocabulary: Vocabulary = PAPER
    words: int = PAPER.words
    own_clauses: tuple[int, ...] = ()
    own_actions: tuple[int, ...] = ()

    @classmethod
    def of(cls, sayers: Iterable[Sayer]) -> Language:
        """What any of them can say. Raises InputError if they are not of one vocabulary."""
        sayers = list(sayers)
        vocabularies = {one.vocabulary for one in sayers}
        if len(vocabularies) != 1:
            raise InputError("grammars of different vocabularies cannot share a batch; accepted are those of one")
        (vocabulary,) = vocabularies
        clauses = {k for one in sayers for k in one.clauses if vocabulary.clauses[k].kind == "own"}
        actions = {k for one in sayers for k in one.actions if k >= vocabulary.first_own}
        words = max(k // WORD_BITS + 1 for one in sayers for k in one.clauses)
        return cls(vocabulary, words, tuple(sorted(clauses)), tuple(sorted(actions)))

    @classmethod
    def whole(cls, vocabulary: Vocabulary) -> Language:
        """Everything that the vocabulary has."""
        clauses = (k for k, clause in enumerate(vocabulary.clauses) if clause.kind == "own")
        return cls(
            vocabulary, vocabulary.words, tuple(clauses), tuple(range(vocabulary.first_own, len(vocabulary.actions)))
        )
