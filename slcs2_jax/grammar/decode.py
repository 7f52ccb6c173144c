"""From codons to rules (paper, "Rule Generation"; model section 5): grammatical evolution's mapping with a limit on
the clauses.

The leftmost non-terminal is decoded first; it takes the option codon mod number of options. The codons are used twice
at most (they wrap once). Options that would lead to more than max_clauses clauses are not on offer and do not count
in the modulus. A single option consumes no codon unless the grammar says so; a start with a single option is the form
of a rule and never does. When the codons have run out, every remaining non-terminal takes its first option of
shortest derivation (fewest clauses, then fewest expansions).

`decode_rule` says this readably; `decode_rules` does it for many rules at once and must agree with it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.bnf import NonTerminal, Option
from slcs2_jax.grammar.check import option_cost
from slcs2_jax.grammar.grammar import Grammar
from slcs2_jax.grammar.ruleset import Rule, RuleSets, parse_rule_text
from slcs2_jax.grammar.tables import DecodeTables, shortest_option
from slcs2_jax.grammar.vocabulary import quote

CODONS = 40  # per rule (assumed: model section 5)
MAX_CODONS = 1024
_BLOCK = 8192  # rules decoded together: their working arrays stay in the cache


def _check_codon(codon: object) -> int:
    whole = isinstance(codon, (int, np.integer)) and not isinstance(codon, bool)
    if not whole or not 0 <= int(codon) <= 255:  # type: ignore[call-overload]
        raise InputError(f"codons: {quote(codon)} is not a whole number in 0..255")
    return int(codon)  # type: ignore[call-overload]


def decode_words(grammar: Grammar, codons: Sequence[int]) -> tuple[str, ...]:
    """The words of the rule that the codons decode to, in the order derived. Raises InputError for codons that are
    none."""
    codons = [_check_codon(codon) for codon in codons]
    if not codons:
        raise InputError("codons: a rule needs at least one")
    costs = grammar.costs
    words: list[str] = []
    todo: list[str | NonTerminal] = [NonTerminal(grammar.start)]  # the undecoded rest of the rule, leftmost symbol last
    spare = grammar.max_clauses - 1 - costs[grammar.start][0]  # clauses that may still be added
    used = 0
    while todo:
        symbol = todo.pop()
        if isinstance(symbol, str):
            words.append(symbol)
            continue
        production = grammar.productions[symbol.name]

        def extra(option: Option, least: int = costs[symbol.name][0]) -> int:
            return option_cost(option, costs)[0] - least

        offers = [option for option in production.options if extra(option) <= spare]
        is_form = symbol.name == grammar.start and len(production.options) == 1
        if is_form or (len(offers) == 1 and not grammar.single_option_consumes):
            chosen = offers[0]
        elif used == 2 * len(codons):
            chosen = production.options[shortest_option(production, costs)]
        else:
            chosen = offers[codons[used % len(codons)] % len(offers)]
            used += 1
        spare -= extra(chosen)
        todo.extend(reversed(chosen.body))
    return tuple(words)


def decode_rule(grammar: Grammar, codons: Sequence[int]) -> Rule:
    """The rule that a string of codons (integers 0..255, any number from 1) decodes to.

    Raises InputError for an empty string or a codon that is no integer in 0..255.
    """
    return parse_rule_text(" ".join(decode_words(grammar, codons)), grammar.vocabulary)


def decode_rules(grammar: Grammar, codons: NDArray[np.integer]) -> tuple[NDArray[np.uint32], NDArray[np.uint8]]:
    """The rules of many strings of codons at once: codons integer [K, L] -> mask uint32[K, W], action
    uint8[K].

    Equal to `decode_rule` row by row. Raises InputError if codons is no integer array [K, L >= 1] of values 0..255.
    """
    codons = np.asarray(codons)
    if codons.ndim != 2 or codons.shape[1] < 1 or not np.issubdtype(codons.dtype, np.integer):
        raise InputError(f"codons: {codons.dtype} {codons.shape} is not an integer array [rules, codons per rule]")
    if codons.dtype != np.uint8:
        bad = codons[(codons < 0) | (codons > 255)]
        if bad.size:
            raise InputError(f"codons: {bad[0]} is not a whole number in 0..255")
        codons = codons.astype(np.uint8)
    count = codons.shape[0]
    mask = np.zeros((count, grammar.vocabulary.words), np.uint32)
    action = np.zeros(count, np.uint8)
    for begin in range(0, count, _BLOCK):
        block = slice(begin, begin + _BLOCK)
        _decode_block(grammar.tables, np.ascontiguousarray(codons[block]), mask[block], action[block])
    return mask, action


def _decode_block(
    tables: DecodeTables, codons: NDArray[np.uint8], mask: NDArray[np.uint32], action: NDArray[np.uint8]
) -> None:
    """Run the stack machine on codons [K, L] until every rule is whole; fill mask [K, W] (zero before) and
    action [K]."""
    count, length = codons.shape
    flat = codons.ravel()
    rule = np.arange(count)  # which rules are still being decoded; the arrays below belong to these
    entry = np.full(count, tables.start_entry)
    state = np.zeros(count, np.intp)
    slack = np.full(count, tables.start_slack)
    used = np.zeros(count, np.intp)
    top = np.ones(count, np.intp)  # where the next entry goes; stack[0] holds 0: nothing left
    stack = np.zeros((tables.depth, count), np.intp)

    def read(words: NDArray[np.intp], where: NDArray[np.intp]) -> None:
        """Feed words to the automata of the rules at `where`; note the clauses that this completes."""
        run = words[where] * tables.states + state[where]
        state[where] = tables.next_state[run]
        done = tables.completed[run]
        some = done.nonzero()[0]
        mask[rule[where[some]]] |= tables.masks[done[some]]

    while rule.size:
        before = tables.entry_words[entry]
        read(before, before.nonzero()[0])
        symbol = tables.entry_symbol[entry]
        offer = symbol * tables.slacks + np.minimum(slack, tables.slacks - 1)
        codon = flat[rule * length + used % length]
        option = tables.offers[tables.offer_first[offer] + codon % tables.offer_count[offer]]
        consumes = ~tables.offer_free[offer]
        late = (consumes & (used == 2 * length)).nonzero()[0]
        option[late] = tables.shortest[symbol[late]]
        consumes[late] = False
        used += consumes
        slack -= tables.option_extra[option]
        leading = tables.option_words[option]
        read(leading, leading.nonzero()[0])
        rest = tables.entry_rest[entry]
        stack[top, rule] = rest  # what is written above the top is never read
        top += rest != 0
        entry = tables.option_entry[option]
        back = (entry == 0).nonzero()[0]
        top[back] -= 1
        entry[back] = stack[top[back], rule[back]]
        finished = back[entry[back] == 0]
        if finished.size:
            action[rule[finished]] = tables.action[state[finished]]
            going = entry.nonzero()[0]
            rule, entry, state, slack, used, top = (array[going] for array in (rule, entry, state, slack, used, top))


def random_rules(
    grammar: Grammar, count: int, rng: np.random.Generator, *, codons: int = CODONS
) -> tuple[NDArray[np.uint32], NDArray[np.uint8]]:
    """`count` rules decoded from uniform random codons: mask uint32[count, W], action uint8[count].

    The generator is drawn from once, for count * codons bytes. Raises InputError for a negative count or codons
    outside 1..1024.
    """
    if count < 0:
        raise InputError(f"count: {count} is negative")
    if not 1 <= codons <= MAX_CODONS:
        raise InputError(f"codons: {codons} is not in 1..{MAX_CODONS}")
    return decode_rules(grammar, rng.integers(0, 256, (count, codons), np.uint8))


def random_rule_sets(
    grammar: Grammar, agents: int, rules: int, rng: np.random.Generator, *, codons: int = CODONS
) -> RuleSets:
    """The random rule-sets of a whole solution: `agents` sets of `rules` rules each. Raises InputError."""
    agents, rules = whole("agents", agents, 1, 64), whole("rules", rules, 1, 1000)
    of_kind("grammar", grammar, Grammar)
    of_kind("rng", rng, np.random.Generator)
    mask, action = random_rules(grammar, agents * rules, rng, codons=codons)
    return RuleSets(mask.reshape(agents, rules, -1), action.reshape(agents, rules), grammar.vocabulary)
