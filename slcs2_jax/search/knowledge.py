"""The designer's rules in the first places of every rule-set, and which of them are reflexes at first.

[n, R] = agents, rules; K = rules of knowledge. They stay in their places: variation changes what is behind them, and
of them the flags alone (`reflexes`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slcs2_jax.config.field import refuse
from slcs2_jax.grammar import Grammar, RuleSets
from slcs2_jax.policy.decision_list import load_decision_list, parse_decision_list

if TYPE_CHECKING:
    from slcs2_jax.config import Settings

_PACKET_ACTIONS = ("collect", "send")


@dataclass(frozen=True, eq=False, kw_only=True)
class Knowledge:
    """What stands in the first places of every rule-set.

    Attributes:
        rules: of one agent, [1, K].
        reflex: may they be reflexes? Otherwise they are rules as any other.
        start: which are, in a random solution: packets, all, or both by turns.
        alone: share of children in which nothing but flags changes.
        text: of the list, as it was written.
    """

    rules: RuleSets
    reflex: bool = False
    start: str = "both"
    alone: float = 0.5
    text: str = ""

    @classmethod
    def of(cls, settings: Settings, grammar: Grammar, text: str | None = None) -> Knowledge | None:
        """As the settings say; None for none. Of a run that goes on, `text` is the list that it was begun with.

        Raises InputError: there is no such list, the grammar cannot say it, or it has more rules than a rule-set.
        """
        given = settings.knowledge
        if given.mode == "none":
            return None
        if text is None:
            known = load_decision_list(given.rules, vocabulary=grammar.vocabulary)
        else:
            known = parse_decision_list(text, name=given.rules, vocabulary=grammar.vocabulary)
        if len(known.rules) > settings.rules.rules:
            most = f"a list of at most rules.rules={settings.rules.rules} rules; it has {len(known.rules)}"
            raise refuse("knowledge.rules", given.rules, most)
        for rule in known.rules:
            if not {*rule.clauses} <= {*grammar.clauses} or rule.action not in grammar.actions:
                sayable = f"rules that grammar={grammar.name} can say, and '{rule.text()}' it cannot"
                raise refuse("knowledge.rules", given.rules, sayable)
        return cls(
            rules=known.rule_sets(1),
            reflex=given.mode == "reflex",
            start=given.start,
            alone=given.alone,
            text=known.text,
        )

    @property
    def count(self) -> int:
        """K."""
        return self.rules.action.shape[1]

    @property
    def about_packets(self) -> np.ndarray:
        """bool[K]: rules that collect or send."""
        kinds = [self.rules.vocabulary.actions[action].kind for action in self.rules.action[0].tolist()]
        return np.array([kind in _PACKET_ACTIONS for kind in kinds])

    def first_flags(self, generation: int) -> np.ndarray:
        """bool[K]: the reflexes of a random solution of this generation."""
        all_of_them = self.start == "all" or (self.start == "both" and generation % 2 == 1)
        return np.ones(self.count, bool) if all_of_them else self.about_packets

    def placed(self, rules: RuleSets, generation: int) -> RuleSets:
        """Rule-sets with these rules in their first places, in the stead of what was there."""
        mask, action = rules.mask.copy(), rules.action.copy()
        mask[:, : self.count], action[:, : self.count] = self.rules.mask, self.rules.action
        reflex = None
        if self.reflex:
            reflex = np.zeros(action.shape, bool)
            reflex[:, : self.count] = self.first_flags(generation)
        return RuleSets(mask, action, rules.vocabulary, reflex, rules.quality)

    def stands_in(self, rules: RuleSets) -> bool:
        """Are the first places of all rule-sets these rules, and no other one a reflex?"""
        if (rules.ids()[:, : self.count] != self.rules.ids()).any():
            return False
        if rules.reflex is None:
            return not self.reflex
        return self.reflex and not rules.reflex[:, self.count :].any()
