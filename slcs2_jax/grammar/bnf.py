"""Reading a grammar in Backus-Naur form: plain text in, productions out, every fault named with its line.

    # comment
    <Condition> ::= <Condition> & <Condition> | packet held
                  | d_si "<" net

A production starts with its non-terminal and `::=` (or `->`); lines that begin with `|` continue it. What stands
between angle brackets and begins with a letter is a non-terminal, the rest are words. Quotes (`"<"`, `"|"`) take away
any other meaning. The first production's non-terminal is the start symbol. The order of the options is kept: decoding
depends on it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.vocabulary import quote, split_words

_NAME = r"<\s*[A-Za-z][\w .\-]{0,59}>"
_HEAD = re.compile(rf"({_NAME})\s*(?:::=|->|→)")
_PIECE = re.compile(
    rf"""\s+ | (?P<comment>\#.*) | "(?P<double>[^"]*)" | '(?P<single>[^']*)' | (?P<name>{_NAME}) | (?P<bar>\|)
    | (?P<open>["']) | (?P<word>(?:(?!{_NAME})[^\s|"'\#])+)""",
    re.VERBOSE,
)


@dataclass(frozen=True)
class NonTerminal:
    """A symbol to be decoded further; `name` is without its angle brackets."""

    name: str


@dataclass(frozen=True)
class Option:
    """One way to decode a non-terminal: words (str) and non-terminals in order, and the line that it stands on (from
    1)."""

    line: int
    body: tuple[str | NonTerminal, ...]

    def children(self) -> list[str]:
        """The names of the non-terminals in it, from the left."""
        return [symbol.name for symbol in self.body if isinstance(symbol, NonTerminal)]


@dataclass
class Production:
    """A non-terminal and its options in the order written."""

    name: str
    line: int
    options: list[Option] = field(default_factory=list)


def _name(text: str) -> str:
    return " ".join(text[1:-1].split())


def _split_line(text: str, line: int) -> list[list[str | NonTerminal]]:
    """The options on one line (after `::=` or with the leading `|`), as lists of symbols; possibly empty ones."""
    options: list[list[str | NonTerminal]] = [[]]
    position = 0
    while position < len(text):
        piece = _PIECE.match(text, position)
        assert piece is not None  # every character begins some piece
        position = piece.end()
        kind = piece.lastgroup
        if kind == "open":
            raise InputError(f"line {line}: the quote {piece.group()} is not closed")
        if kind == "bar":
            options.append([])
        elif kind == "name":
            options[-1].append(NonTerminal(_name(piece.group())))
        elif kind in ("double", "single", "word"):
            options[-1].extend(split_words(piece.group(kind)))
    return options


def _add_options(production: Production, found: list[list[str | NonTerminal]], line: int) -> None:
    for body in found:
        if not body:
            raise InputError(f"line {line}: <{production.name}> has an empty option; an option needs at least one word")
        production.options.append(Option(line, tuple(body)))


def read_bnf(text: str) -> dict[str, Production]:
    """The productions of a grammar text by name, in the order written; the first is the start.

    Raises InputError, naming the line, for text that is no BNF, an empty option, a non-terminal defined twice and one
    without a production.
    """
    productions: dict[str, Production] = {}
    current: Production | None = None
    for line, raw in enumerate(text.removeprefix("\ufeff").replace("\r\n", "\n").split("\n"), start=1):
        stripped = raw.strip()
        if not stripped or stripped.startswith("#"):
            continue
        head = _HEAD.match(stripped)
        if head:
            current = Production(_name(head.group(1)), line)
            if current.name in productions:
                first = productions[current.name].line
                raise InputError(f"line {line}: <{current.name}> is already defined in line {first}")
            productions[current.name] = current
            found = _split_line(stripped[head.end() :], line)
            if found == [[]]:  # `<A> ::=` alone: the options follow on lines of their own
                continue
        elif stripped.startswith("|") and current is not None:
            found = _split_line(stripped[1:], line)
        else:
            raise InputError(
                f"line {line}: expected '<Name> ::= option | option' or '| option', found {quote(stripped)}"
            )
        _add_options(current, found, line)
    _check_complete(productions)
    return productions


def _check_complete(productions: dict[str, Production]) -> None:
    """Every non-terminal named has a production with options."""
    if not productions:
        raise InputError("no production; expected lines such as '<Condition> ::= packet held | no packet held'")
    names = ", ".join(f"<{name}>" for name in list(productions)[:40])
    for production in productions.values():
        if not production.options:
            raise InputError(f"line {production.line}: <{production.name}> has no option")
        for option in production.options:
            for child in option.children():
                if child not in productions:
                    raise InputError(f"line {option.line}: <{child}> has no production; productions are: {names}")
