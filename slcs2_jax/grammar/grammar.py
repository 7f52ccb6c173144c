"""A grammar that is ready for use: read, checked against the vocabulary, and compiled."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field
from functools import cached_property
from importlib import resources
from typing import Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.settings import Settings
from slcs2_jax.grammar.bnf import Production, read_bnf
from slcs2_jax.grammar.check import Cost, derive, shortest_derivations
from slcs2_jax.grammar.source import MAX_BYTES, read_source
from slcs2_jax.grammar.tables import DecodeTables, compile_tables
from slcs2_jax.grammar.vocabulary import PAPER, WORD_BITS, Vocabulary, quote

GRAMMARS = ("main", "channel", "power", "both")
MAX_CLAUSES = 64  # the greatest max_clauses accepted


@dataclass(frozen=True, eq=False)
class Grammar:
    """Which rules there are and how codons decode to them. Make one with `load_grammar` or `parse_grammar`.

    name: main, channel, power, both or the user's path. clauses, actions: the numbers that its rules can hold,
    ascending. costs: per non-terminal the least (joints, expansions) of a text derived from it.
    """

    name: str
    text: str = field(repr=False)
    max_clauses: int
    single_option_consumes: bool
    start: str
    productions: dict[str, Production] = field(repr=False)
    costs: dict[str, Cost] = field(repr=False)
    clauses: tuple[int, ...] = field(repr=False)
    actions: tuple[int, ...] = field(repr=False)
    tables: DecodeTables = field(repr=False)
    vocabulary: Vocabulary = field(repr=False)

    @classmethod
    def of(cls, settings: Settings, text: str | None = None) -> Grammar:
        """The grammar that settings name, over all parts that are registered now; from its `text` if that is at hand.

        Raises InputError as `load_grammar` and `parse_grammar` do.
        """
        rules = settings.rules
        options: dict[str, Any] = {
            "max_clauses": rules.max_clauses,
            "single_option_consumes": rules.single_option_consumes,
            "vocabulary": Vocabulary.current(settings.radio.channels),
        }
        if text is None:
            return load_grammar(rules.grammar, **options)
        return parse_grammar(text, name=rules.grammar, **options)

    @cached_property
    def channels_used(self) -> tuple[int, ...]:
        """Indices of the channels on which its rules transmit or of which they measure the noise, ascending; (0,) if
        none."""
        known = self.vocabulary
        heard = {known.clauses[k].channel for k in self.clauses} | {known.actions[k].channel for k in self.actions}
        return tuple(sorted(heard - {-1})) or (0,)

    @property
    def words(self) -> int:
        """How many words of a clause mask its rules can need."""
        return max(self.clauses) // WORD_BITS + 1

    @cached_property
    def source_hash(self) -> str:
        """SHA-256 (hex) of everything that decides how codons decode: the text and the two settings."""
        settings = f"{self.max_clauses} {self.single_option_consumes}\n"
        return hashlib.sha256((settings + self.text).encode("utf-8", "surrogatepass")).hexdigest()


def parse_grammar(
    text: str,
    *,
    name: str = "text",
    max_clauses: int = 8,
    single_option_consumes: bool = False,
    vocabulary: Vocabulary = PAPER,
) -> Grammar:
    """The grammar that a BNF text describes (see bnf.py for the notation).

    Raises InputError of one line, naming the grammar and the line, for a text that is no BNF, too large, not
    terminating, or derives anything that is no rule of the vocabulary; and if its shortest rule has more than
    max_clauses clauses.
    """
    label = f"grammar {quote(name, 120)}"
    if not isinstance(text, str):
        raise InputError(f"{label}: expected text, got {type(text).__name__}")
    if isinstance(max_clauses, bool) or not isinstance(max_clauses, int) or not 1 <= max_clauses <= MAX_CLAUSES:
        raise InputError(f"max_clauses: {quote(max_clauses)} is not a whole number in 1..{MAX_CLAUSES}")
    if not isinstance(single_option_consumes, bool):
        raise InputError(f"single_option_consumes: {quote(single_option_consumes)} is neither true nor false")
    if len(text) > MAX_BYTES:
        raise InputError(f"{label}: {len(text)} characters are too many; at most {MAX_BYTES} are accepted")
    try:
        productions = read_bnf(text)
        costs = shortest_derivations(productions)
        start = next(iter(productions))
        derivable = derive(productions, start, vocabulary)
        if costs[start][0] + 1 > max_clauses:
            line = productions[start].line
            raise InputError(
                f"line {line}: no rule has max_clauses={max_clauses} clauses or fewer; accept more clauses"
            )
        tables = compile_tables(productions, start, costs, derivable, vocabulary, max_clauses, single_option_consumes)
    except InputError as error:
        raise InputError(f"{label}: {error}") from None
    return Grammar(
        name, text, max_clauses, single_option_consumes, start, productions, costs,
        derivable.clauses, derivable.actions, tables, vocabulary,
    )  # fmt: skip


def load_grammar(
    name_or_path: str | os.PathLike[str],
    *,
    max_clauses: int = 8,
    single_option_consumes: bool = False,
    vocabulary: Vocabulary = PAPER,
) -> Grammar:
    """One of the paper's grammars (main, channel, power, both) or the user's own from a BNF file.

    max_clauses: clauses that a rule may have. single_option_consumes: whether a production with a single option takes
    a codon. Raises InputError of one line if there is no such grammar or file, the file is no text of at most 64 KiB,
    or `parse_grammar` refuses it.
    """
    if isinstance(name_or_path, str) and name_or_path in GRAMMARS:
        text = (resources.files(__package__) / "bnf" / f"{name_or_path}.bnf").read_text(encoding="utf-8")
    else:
        text = read_source("grammar", name_or_path, f"accepted are {', '.join(GRAMMARS)} or the path of a BNF file")
    return parse_grammar(
        text,
        name=str(name_or_path),
        max_clauses=max_clauses,
        single_option_consumes=single_option_consumes,
        vocabulary=vocabulary,
    )
