"""Decision lists as text: an ordered list of rules of which the first that holds acts; the designed behaviour is one.

One rule a line, `packet held & d_si < net => send to si`; what follows `#` is a remark.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from importlib import resources

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.ruleset import Rule, RuleSets, parse_rule_text
from slcs2_jax.grammar.source import read_source
from slcs2_jax.grammar.vocabulary import WORD_BITS, Vocabulary, quote

DECISION_LISTS = ("designed",)
MOST_RULES = 1000


@dataclass(frozen=True)
class DecisionList:
    """A list that all agents share. Make one with `load_decision_list` or `parse_decision_list`.

    name: designed, or the user's path. text: as it was written. rules: in order.
    """

    name: str
    text: str = field(repr=False)
    rules: tuple[Rule, ...]

    @property
    def vocabulary(self) -> Vocabulary:
        """That its rules are said in."""
        return self.rules[0].vocabulary

    @property
    def clauses(self) -> tuple[int, ...]:
        """Numbers of the clauses that its rules state, ascending."""
        return tuple(sorted({clause for rule in self.rules for clause in rule.clauses}))

    @property
    def actions(self) -> tuple[int, ...]:
        """Numbers of the actions that its rules take, ascending."""
        return tuple(sorted({rule.action for rule in self.rules}))

    @property
    def channels_used(self) -> tuple[int, ...]:
        """Indices of the channels that its rules name, ascending; the first channel if they name none."""
        return self.rule_sets(1).channels_used

    @property
    def words(self) -> int:
        """Words of a mask that its conditions need."""
        return max(self.clauses) // WORD_BITS + 1

    def rule_sets(self, agents: int) -> RuleSets:
        """The same rules for each of so many agents."""
        return RuleSets.from_rules([self.rules] * agents)


def parse_decision_list(text: str, *, name: str = "text", vocabulary: Vocabulary | None = None) -> DecisionList:
    """The decision list that a text describes, in a vocabulary: by default that of all parts registered now.

    Raises InputError of one line that names the list, the line, and what is accepted.
    """
    label, known = f"policy {quote(name, 120)}", vocabulary or Vocabulary.current()
    rules = []
    for number, line in enumerate(text.splitlines(), start=1):
        said = line.split("#", 1)[0]
        if not said.strip():
            continue
        try:
            rules.append(parse_rule_text(said, known))
        except InputError as error:
            raise InputError(f"{label}: line {number}: {error}") from None
    if not 1 <= len(rules) <= MOST_RULES:
        raise InputError(f"{label}: {len(rules)} rules; accepted are 1 to {MOST_RULES}, one a line")
    return DecisionList(name, text, tuple(rules))


def load_decision_list(name_or_path: str | os.PathLike[str], *, vocabulary: Vocabulary | None = None) -> DecisionList:
    """The designed behaviour (`designed`) or the user's own list from a text file.

    Raises InputError of one line if there is no such list or file, or `parse_decision_list` refuses it.
    """
    if isinstance(name_or_path, str) and name_or_path in DECISION_LISTS:
        text = (resources.files(__package__) / f"{name_or_path}.txt").read_text(encoding="utf-8")
    else:
        known = f"accepted are {', '.join(DECISION_LISTS)} or the path of a text file"
        text = read_source("policy", name_or_path, known)
    return parse_decision_list(text, name=str(name_or_path), vocabulary=vocabulary)
