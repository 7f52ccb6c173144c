"""Behaviours made by hand, as text: an ordered list of rules of which the first that holds acts.

One rule a line, `packet held & d_si < net => send to si`; what follows `#` is a remark.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from importlib import resources

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.ruleset import Rule, RuleSets, parse_rule_text
from slcs2_jax.grammar.source import read_source
from slcs2_jax.grammar.vocabulary import ACTIONS, CLAUSES, quote

BEHAVIOURS = ("designed",)
MAX_RULES = 1000


@dataclass(frozen=True)
class Behaviour:
    """A behaviour that all agents share. Make one with `load_behaviour` or `parse_behaviour`.

    name: designed, or the user's path. text: as it was written. rules: in order.
    """

    name: str
    text: str = field(repr=False)
    rules: tuple[Rule, ...]

    @property
    def channels_used(self) -> tuple[int, ...]:
        """Indices of the channels that its rules name, ascending; the first channel if they name none."""
        named = {ACTIONS[rule.action].channel for rule in self.rules}
        named |= {CLAUSES[clause].channel for rule in self.rules for clause in rule.clauses}
        return tuple(sorted(named - {-1})) or (0,)

    @property
    def words(self) -> int:
        """Words of 32 clauses that its conditions need: 3 or 4, as a grammar's."""
        return 3 if max(clause for rule in self.rules for clause in rule.clauses) < 96 else 4

    def rule_sets(self, agents: int) -> RuleSets:
        """The same rules for each of so many agents."""
        return RuleSets.from_rules([self.rules] * agents)


def parse_behaviour(text: str, *, name: str = "text") -> Behaviour:
    """The behaviour that a text describes.

    Raises InputError of one line that names the behaviour, the line, and what is accepted.
    """
    label = f"controller {quote(name, 120)}"
    rules = []
    for number, line in enumerate(text.splitlines(), start=1):
        said = line.split("#", 1)[0]
        if not said.strip():
            continue
        try:
            rules.append(parse_rule_text(said))
        except InputError as error:
            raise InputError(f"{label}: line {number}: {error}") from None
    if not 1 <= len(rules) <= MAX_RULES:
        raise InputError(f"{label}: {len(rules)} rules; accepted are 1 to {MAX_RULES}, one a line")
    return Behaviour(name, text, tuple(rules))


def load_behaviour(name_or_path: str | os.PathLike[str]) -> Behaviour:
    """The designed behaviour (`designed`) or the user's own from a text file.

    Raises InputError of one line if there is no such behaviour or file, or `parse_behaviour` refuses it.
    """
    if isinstance(name_or_path, str) and name_or_path in BEHAVIOURS:
        text = (resources.files(__package__) / f"{name_or_path}.txt").read_text(encoding="utf-8")
    else:
        known = f"accepted are {', '.join(BEHAVIOURS)} or the path of a text file"
        text = read_source("controller", name_or_path, known)
    return parse_behaviour(text, name=str(name_or_path))
