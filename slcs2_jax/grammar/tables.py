"""A grammar compiled to integer tables, for decoding many rules at once without a Python loop over rules.

The decoder is a stack machine. A stack entry is an occurrence of a non-terminal in some option's body, with the words
before it; taking an option reads its leading words, makes its first non-terminal the current entry and leaves the
rest of the present body on the stack. Reading words is one look-up: [words, automaton state] -> next state and the
set of clauses completed on the way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.bnf import Option, Production
from slcs2_jax.grammar.check import Cost, Derivable, Words, automaton, option_cost, segments
from slcs2_jax.grammar.vocabulary import NO_ACTION, WORD_BITS, Vocabulary

MAX_OFFERS = 2_000_000  # entries that the table of offers may have; the paper's grammars need about a hundred


@dataclass(frozen=True, eq=False)
class DecodeTables:
    """Sizes: E entries, D non-terminals (0: the end of a body, which only reads words), O options, U distinct runs of
    words (0: none), Q automaton states, S classes of slack (joints that may still be added), G distinct sets of
    completed clauses (0: none)."""

    entry_words: NDArray[np.intp]  # [E] words before the entry's non-terminal
    entry_symbol: NDArray[np.intp]  # [E]
    entry_rest: NDArray[np.intp]  # [E] the entry after this one in the same body; 0 none
    offer_count: NDArray[np.intp]  # [D*S] options on offer
    offer_first: NDArray[np.intp]  # [D*S] where they stand in offers
    offer_free: NDArray[np.bool_]  # [D*S] whether choosing consumes no codon
    offers: NDArray[np.intp]  # option numbers
    shortest: NDArray[np.intp]  # [D] option taken when the codons have run out
    option_words: NDArray[np.intp]  # [O] leading words
    option_extra: NDArray[np.intp]  # [O] joints beyond the least that its non-terminal needs
    option_entry: NDArray[np.intp]  # [O] first entry; 0 none
    next_state: NDArray[np.intp]  # [U*Q]
    completed: NDArray[np.intp]  # [U*Q]
    masks: NDArray[np.uint32]  # [G, W] clause masks of the sets
    action: NDArray[np.uint8]  # [Q] action completed by the state, else NO_ACTION
    states: int  # Q
    slacks: int  # S
    start_entry: int
    start_slack: int
    depth: int  # entries that the stack can hold at most


def shortest_option(production: Production, costs: dict[str, Cost]) -> int:
    """Index of the first option of a shortest derivation: fewest clauses, then fewest expansions."""
    return min(range(len(production.options)), key=lambda k: option_cost(production.options[k], costs))


def _numbered(things: list[Words]) -> dict[Words, int]:
    return {thing: k for k, thing in enumerate(dict.fromkeys(things))}


class _Entries:
    """Numbers the occurrences of non-terminals in option bodies; entry 0 and non-terminal 0 stand for nothing."""

    def __init__(self, productions: dict[str, Production]) -> None:
        self.symbols = {name: k for k, name in enumerate(productions, start=1)}
        self.words: list[Words] = [()]
        self.symbol = [0]
        self.rest = [0]

    def add(self, words: Words, name: str | None, rest: int) -> int:
        self.words.append(words)
        self.symbol.append(0 if name is None else self.symbols[name])
        self.rest.append(rest)
        return len(self.words) - 1

    def add_body(self, option: Option) -> tuple[Words, int]:
        """The option's leading words and its first entry (0 if it has no non-terminal)."""
        parts = list(segments(option))
        if len(parts) == 1:
            return parts[0][0], 0
        trailing = parts.pop()
        rest = self.add(trailing[0], None, 0) if trailing[0] else 0
        for words, name in reversed(parts[1:]):
            rest = self.add(words, name, rest)
        return parts[0][0], self.add((), parts[0][1], rest)


def _word_tables(
    words: dict[Words, int], derivable: Derivable, vocabulary: Vocabulary
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """next_state, completed, masks and action: see DecodeTables. Only runs that some rule takes are filled."""
    reader = automaton(vocabulary)
    states = len(reader.text)
    next_state = np.zeros((len(words), states), np.intp)
    completed = np.zeros((len(words), states), np.intp)
    next_state[words[()]] = np.arange(states)
    sets: dict[frozenset[int], int] = {frozenset(): 0}
    for (state, said), (after, done) in derivable.runs.items():
        next_state[words[said], state] = after
        completed[words[said], state] = sets.setdefault(done, len(sets))
    masks = np.zeros((len(sets), vocabulary.words), np.uint32)
    for done, row in sets.items():
        for clause in done:
            masks[row, clause // WORD_BITS] |= np.uint32(1 << (clause % WORD_BITS))
    action = np.full(states, NO_ACTION, np.uint8)
    for state, number in reader.action.items():
        action[state] = number
    return next_state.ravel(), completed.ravel(), masks, action


def _offer_tables(
    productions: dict[str, Production],
    extras: dict[str, list[int]],
    max_joints: int,
    form: str | None,
    single_option_consumes: bool,
) -> tuple[int, NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """S, offer_count, offer_first, offer_free, offers: see DecodeTables. `form` is a start that costs no codon."""
    slacks = 1 + min(max_joints, max(max(found) for found in extras.values()))
    if slacks * sum(len(found) for found in extras.values()) > MAX_OFFERS:
        raise InputError("the grammar has too many options for this max_clauses; use fewer")
    count, first, free, offers = [1] * slacks, [0] * slacks, [True] * slacks, [0]
    begin = 1
    for name in productions:
        for slack in range(slacks):
            on_offer = [begin + k for k, extra in enumerate(extras[name]) if extra <= slack]
            count.append(len(on_offer))
            first.append(len(offers))
            free.append(name == form or (len(on_offer) == 1 and not single_option_consumes))
            offers.extend(on_offer)
        begin += len(extras[name])
    return slacks, np.array(count), np.array(first), np.array(free), np.array(offers)


def compile_tables(
    productions: dict[str, Production],
    start: str,
    costs: dict[str, Cost],
    derivable: Derivable,
    vocabulary: Vocabulary,
    max_clauses: int,
    single_option_consumes: bool,
) -> DecodeTables:
    """The tables of a checked grammar. A start with one option is the form of a rule: taking it never consumes a
    codon."""
    entries = _Entries(productions)
    start_entry = entries.add((), start, 0)
    option_words: list[Words] = [()]
    option_extra, option_entry, shortest = [0], [0], [0]
    extras: dict[str, list[int]] = {}
    for name, production in productions.items():
        extras[name] = [min(option_cost(o, costs)[0] - costs[name][0], max_clauses) for o in production.options]
        shortest.append(len(option_words) + shortest_option(production, costs))
        for option in production.options:
            words, entry = entries.add_body(option)
            option_words.append(words)
            option_entry.append(entry)
        option_extra.extend(extras[name])
    form = start if len(productions[start].options) == 1 else None
    slack = max_clauses - 1 - costs[start][0]
    slacks, count, first, free, offers = _offer_tables(productions, extras, slack, form, single_option_consumes)
    words_number = _numbered([(), *entries.words, *option_words])
    next_state, completed, masks, action = _word_tables(words_number, derivable, vocabulary)
    longest = max(len(text.split()) for text in automaton(vocabulary).text) + 1
    return DecodeTables(
        entry_words=np.array([words_number[words] for words in entries.words]),
        entry_symbol=np.array(entries.symbol),
        entry_rest=np.array(entries.rest),
        offer_count=count,
        offer_first=first,
        offer_free=free,
        offers=offers,
        shortest=np.array(shortest),
        option_words=np.array([words_number[words] for words in option_words]),
        option_extra=np.array(option_extra),
        option_entry=np.array(option_entry),
        next_state=next_state,
        completed=completed,
        masks=masks,
        action=action,
        states=len(automaton(vocabulary).text),
        slacks=slacks,
        start_entry=start_entry,
        start_slack=slack,
        # every entry left on the stack yields at least a word of its own, and a rule has no more words than this
        depth=2 + (max_clauses + 1) * longest,
    )
