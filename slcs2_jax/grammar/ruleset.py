"""Rules as the program keeps them: a clause mask and an action number; printing, parsing and numbering them.

Two rules are equal iff their mask and action are (model section 5): a mask is the condition with its clauses sorted
and duplicates dropped.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.vocabulary import PAPER, WORD_BITS, Vocabulary, quote, split_words


@dataclass(frozen=True)
class Rule:
    """One rule: clause numbers (ascending, each once) and an action number of a vocabulary."""

    clauses: tuple[int, ...]
    action: int
    vocabulary: Vocabulary = PAPER

    def mask(self) -> NDArray[np.uint32]:
        """The condition as a mask, uint32[W]: bit k % 32 of word k // 32 is clause k."""
        mask = np.zeros(self.vocabulary.words, np.uint32)
        for clause in self.clauses:
            mask[clause // WORD_BITS] |= np.uint32(1 << (clause % WORD_BITS))
        return mask

    def text(self) -> str:
        """The rule as a person would read it: `packet held & d_si < net => send to si`."""
        condition = " & ".join(self.vocabulary.clause_text(clause) for clause in self.clauses)
        return f"{condition} => {self.vocabulary.action_text(self.action)}"


def make_rule(clauses: Iterable[int], action: int, vocabulary: Vocabulary = PAPER) -> Rule:
    """The rule of these clause numbers in any order and an action. Raises InputError for unknown numbers or no
    clause."""
    kept = tuple(sorted({int(clause) for clause in clauses}))
    if not kept:
        raise InputError("rule: a condition needs at least one clause")
    rule = Rule(kept, int(action), vocabulary)
    rule.text()  # refuses unknown numbers
    return rule


def rule_from_mask(mask: NDArray[np.uint32], action: int, vocabulary: Vocabulary = PAPER) -> Rule:
    """The rule of a mask uint32[W] and an action number. Raises InputError for bits or an action that mean nothing."""
    bits = np.unpackbits(np.ascontiguousarray(mask, dtype="<u4").view(np.uint8), bitorder="little")
    return make_rule(np.flatnonzero(bits).tolist(), action, vocabulary)


def parse_rule_text(text: str, vocabulary: Vocabulary = PAPER) -> Rule:
    """The rule that a text such as `packet held & d_si < net => send to si` says; the inverse of `Rule.text`.

    Raises InputError of one line naming the clause or action that is not known, or the form expected.
    """
    words = split_words(text)
    if words.count("=>") != 1:
        raise InputError(f"rule: {quote(text)} is not of the form 'clause & clause => action'")
    arrow = words.index("=>")
    clauses: list[int] = []
    current: list[str] = []
    for word in words[:arrow]:
        if word == "&":
            clauses.append(vocabulary.parse_clause(" ".join(current)))
            current = []
        else:
            current.append(word)
    clauses.append(vocabulary.parse_clause(" ".join(current)))
    return make_rule(clauses, vocabulary.parse_action(" ".join(words[arrow + 1 :])), vocabulary)


def _finish(x: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """splitmix64's finaliser: a bijection of 64-bit words in which every input bit sways every output bit."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def rule_ids(mask: NDArray[np.uint32], action: NDArray[np.uint8]) -> NDArray[np.uint64]:
    """A 64-bit hash of each rule, uint64[...], for mask uint32[..., W] and action uint8[...].

    h = f(a + g), h = f(h ^ (w1:w0) + g), h = f(h ^ (w3:w2) + g), ... with splitmix64's finaliser f and increment g;
    w1:w0 is word 1 in the upper and word 0 in the lower half, and a missing last word is 0. Rules that differ in action
    alone, or in two adjacent words alone, never collide.
    """
    step = np.uint64(0x9E3779B97F4A7C15)
    wide = np.asarray(mask, np.uint32).astype(np.uint64)
    ids = _finish(np.atleast_1d(np.asarray(action)).astype(np.uint64) + step)
    for low in range(0, wide.shape[-1], 2):
        high = wide[..., low + 1] << np.uint64(32) if low + 1 < wide.shape[-1] else np.uint64(0)
        ids = _finish((ids ^ (wide[..., low] | high)) + step)
    return ids.reshape(wide.shape[:-1])


@dataclass(frozen=True, eq=False)
class RuleSets:
    """The rules of a whole solution: n agents with R rules each, W words of the vocabulary to a mask.

    Attributes:
        mask: uint32[n, R, W], clauses.
        action: uint8[n, R].
        vocabulary: what the numbers mean.
        reflex: bool[n, R], rules that act whenever they hold, before any choice; None for none (`docs/model.md`).
        quality: float32[n, R], q at the start of an episode; None for that of the settings.

    Raises InputError if the arrays' types or shapes are not these, a rule has no clause, a number means nothing, or a
    quality is not finite.
    """

    mask: NDArray[np.uint32]
    action: NDArray[np.uint8]
    vocabulary: Vocabulary = PAPER
    reflex: NDArray[np.bool_] | None = None
    quality: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        mask, action, known = self.mask, self.action, self.vocabulary
        if mask.dtype != np.uint32 or action.dtype != np.uint8:
            raise InputError(f"rule-sets: dtypes {mask.dtype}, {action.dtype} are not uint32, uint8")
        if action.ndim != 2 or mask.shape != (*action.shape, known.words):
            raise InputError(f"rule-sets: shapes {mask.shape}, {action.shape} are not [n, R, {known.words}], [n, R]")
        if (action >= len(known.actions)).any():
            raise InputError(f"rule-sets: action {action.max()} is not one of 0..{len(known.actions) - 1}")
        if not mask.any(axis=-1).all():
            raise InputError("rule-sets: a rule has no clause")
        unused = known.words * WORD_BITS - len(known.clauses)
        if unused and (mask[..., -1] >> np.uint32(WORD_BITS - unused)).any():
            raise InputError(f"rule-sets: a mask has a bit beyond clause {len(known.clauses) - 1}")
        for name, dtype in (("reflex", np.bool_), ("quality", np.float32)):
            array = getattr(self, name)
            if array is None:
                continue
            if array.shape != action.shape or array.dtype != dtype:
                raise InputError(f"rule-sets: {name} is {array.dtype}{list(array.shape)}, not of each rule")
            if not np.isfinite(array).all():
                raise InputError(f"rule-sets: {name} is not finite everywhere")

    def ids(self) -> NDArray[np.uint64]:
        """The rules' hashes, uint64[n, R]; equal rules have equal ones. See `rule_ids`."""
        return rule_ids(self.mask, self.action)

    def rule(self, agent: int, index: int) -> Rule:
        """Rule `index` of agent `agent`."""
        return rule_from_mask(self.mask[agent, index], int(self.action[agent, index]), self.vocabulary)

    def text(self, agent: int, index: int) -> str:
        """Rule `index` of agent `agent` in words."""
        return self.rule(agent, index).text()

    @property
    def channels_used(self) -> tuple[int, ...]:
        """Indices of the channels that the rules name, ascending; the first channel if they name none."""
        known = self.vocabulary
        said = np.bitwise_or.reduce(self.mask, axis=(0, 1))
        clauses = np.flatnonzero(np.unpackbits(said.astype("<u4").view(np.uint8), bitorder="little"))
        named = {known.clauses[k].channel for k in clauses.tolist()}
        named |= {known.actions[k].channel for k in np.unique(self.action).tolist()}
        return tuple(sorted(named - {-1})) or (0,)

    @classmethod
    def from_rules(cls, rules: Sequence[Sequence[Rule]]) -> RuleSets:
        """The rule-sets of n agents with equally many rules each, of one vocabulary."""
        sizes = {len(agent) for agent in rules}
        if len(sizes) != 1:
            raise InputError(f"rule-sets: agents have {sorted(sizes)} rules; all must have equally many")
        mask = np.array([[rule.mask() for rule in agent] for agent in rules], np.uint32)
        action = np.array([[rule.action for rule in agent] for agent in rules], np.uint8)
        return cls(mask.reshape(*action.shape, -1), action, rules[0][0].vocabulary)
