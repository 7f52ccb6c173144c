"""slcs2 parts: every kind of part that can be replaced, the setting that chooses it, and the parts there are."""

from __future__ import annotations

from collections.abc import Iterator

from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.registry import KINDS, Registry

TAKES_SETTINGS = False
OPTIONS = ()
HELP = """\
slcs2 parts [KIND] [plugins=[MODULE]]: the parts that a swarm, its world and its search are made of

For each kind the setting that chooses a part, what it is for, and the parts there are, those of your plug-ins with the
module they come from. With a KIND only that one; of clauses, actions and move targets then every word.
"""
_WORDS = ("clause", "action", "move target")  # said in rules, and chosen by a grammar


def run(arguments: list[str]) -> int:
    """Print the parts that the arguments ask for."""
    for argument in arguments:
        if argument.startswith("-") or "=" in argument:
            raise refuse("option", argument, "slcs2 parts [KIND] [plugins=[MODULE]]")
    kind = " ".join(arguments)
    if kind and kind not in KINDS:
        raise InputError(f"parts: no kind {kind!r}; accepted is one of {', '.join(KINDS)}")
    for registry in [KINDS[kind]] if kind else KINDS.values():
        print("\n".join(_lines(registry, every_word=bool(kind))), end="\n\n")
    return 0


def _lines(registry: Registry, *, every_word: bool) -> Iterator[str]:
    yield f"{registry.kind}: {registry.meaning} ({registry.setting}=)"
    if registry.kind in _WORDS:
        yield from _words(registry.kind, every_word)
    names = registry.names()
    width = max(map(len, names), default=0)
    for name in names:
        home = registry.home(name)
        yield f"  {name:{width}}  {registry.summary(name)}" + (f"  [plug-in {home}]" if home else "")


def _words(kind: str, every_word: bool) -> Iterator[str]:
    """The paper's words of a kind, or how many there are."""
    from slcs2_jax.grammar.vocabulary import MOVE_TARGETS, PAPER

    if kind == "move target":
        words: list[str] = list(MOVE_TARGETS)
    else:
        phrases = PAPER.clause_phrases if kind == "clause" else PAPER.action_phrases
        words = [said[0] for said in phrases]
    if every_word:
        yield from (f"  {word}" for word in words)
    else:
        yield f"  {len(words)} of the paper's: slcs2 parts {kind}"
