"""Whether a grammar's rules all end and all mean something: done once when a grammar is loaded, exactly and without
enumerating rules.

`shortest_derivations` finds what each non-terminal costs at least. `derive` runs every derivable text at once through
an automaton that knows the vocabulary's phrases: for each non-terminal and each automaton state in which it may be
met, the set of states in which its text may end. A grammar has infinitely many rules, but only so many of those
pairs.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.bnf import NonTerminal, Option, Production
from slcs2_jax.grammar.vocabulary import Vocabulary, quote, split_words

CONDITION, ACTION = 0, 1  # the automaton's states at the start of a condition and of the action
MAX_WORK = 200_000  # automaton runs that a grammar may take to check; the paper's take some hundreds

Words = tuple[str, ...]
Cost = tuple[int, int]  # joints between clauses (`&`), then expansions


class PhraseAutomaton:
    """Reads a rule word by word. A state is a beginning of some clause or action phrase; `clause` and `action` say
    which it completes."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self.successors: list[dict[str, int]] = [{}, {}]
        self.text = ["", ""]
        self.clause: dict[int, int] = {}
        self.action: dict[int, int] = {}
        for root, phrases, complete in (
            (CONDITION, vocabulary.clause_phrases, self.clause),
            (ACTION, vocabulary.action_phrases, self.action),
        ):
            for number, said in enumerate(phrases):
                for phrase in said:
                    complete[self._add(root, split_words(phrase))] = number

    def _add(self, state: int, words: Words) -> int:
        for word in words:
            if word not in self.successors[state]:
                self.successors[state][word] = len(self.text)
                self.text.append(f"{self.text[state]} {word}".strip())
                self.successors.append({})
            state = self.successors[state][word]
        return state

    def step(self, state: int, word: str) -> int | None:
        """The state after one more word; None if no rule goes on so. `&` and `=>` may follow a complete clause."""
        if word in ("&", "=>"):
            if state not in self.clause:
                return None
            return CONDITION if word == "&" else ACTION
        return self.successors[state].get(word)

    def run(self, state: int, words: Words) -> tuple[int, frozenset[int]]:
        """The state after the words and the clauses completed on the way. Raises InputError at a word that cannot
        follow."""
        done = set()
        for word in words:
            after = self.step(state, word)
            if after is None:
                raise InputError(self.complaint(state, word))
            if word in ("&", "=>"):
                done.add(self.clause[state])
            state = after
        return state, frozenset(done)

    def complaint(self, state: int, word: str) -> str:
        """Why `word` (empty: the end of the rule) cannot come in this state, with the words that can."""
        names = list(self.successors[state])
        if state in self.clause:
            names += ["&", "=>"]
        if state in self.action:
            names += ["(end of the rule)"]
        before = f"after {quote(self.text[state])}" if self.text[state] else "at the start of a condition or action"
        what = f"{quote(word)} is not known" if word else "the rule ends"
        return f"{before} {what}; what exists there: {', '.join(names)}"


@lru_cache(maxsize=64)
def automaton(vocabulary: Vocabulary) -> PhraseAutomaton:
    """The automaton of a vocabulary, made once."""
    return PhraseAutomaton(vocabulary)


def option_cost(option: Option, costs: dict[str, Cost]) -> Cost:
    """The least cost of an option: its own joints plus its non-terminals' least; expansions count the option itself."""
    joints = sum(symbol == "&" for symbol in option.body)
    children = [costs[name] for name in option.children()]
    return joints + sum(cost[0] for cost in children), 1 + sum(cost[1] for cost in children)


def _in_circle(productions: dict[str, Production], name: str, costs: dict[str, Cost]) -> str:
    """A non-terminal that leads back to itself, found from one that never terminates: the cause rather than who
    suffers from it."""
    seen = set()
    while name not in seen:
        seen.add(name)
        name = next(child for option in productions[name].options for child in option.children() if child not in costs)
    return name


def shortest_derivations(productions: dict[str, Production]) -> dict[str, Cost]:
    """For each non-terminal the least (joints, expansions) of a text derived from it; Knuth's generalisation of
    Dijkstra's algorithm.

    Raises InputError for a non-terminal from which no text can be derived.
    """
    users: dict[str, list[tuple[str, int]]] = defaultdict(list)
    missing: dict[tuple[str, int], int] = {}
    queue: list[tuple[Cost, str]] = []
    costs: dict[str, Cost] = {}
    for production in productions.values():
        for index, option in enumerate(production.options):
            children = option.children()
            missing[production.name, index] = len(children)
            for child in children:
                users[child].append((production.name, index))
            if not children:
                heapq.heappush(queue, (option_cost(option, costs), production.name))
    while queue:
        cost, name = heapq.heappop(queue)
        if name in costs:
            continue
        costs[name] = cost
        for user, index in users[name]:
            missing[user, index] -= 1
            if missing[user, index] == 0 and user not in costs:
                heapq.heappush(queue, (option_cost(productions[user].options[index], costs), user))
    endless = next((name for name in productions if name not in costs), None)
    if endless is not None:
        name = _in_circle(productions, endless, costs)
        raise InputError(
            f"line {productions[name].line}: <{name}> cannot terminate; it needs an option that leads to words only"
        )
    return costs


def segments(option: Option) -> Iterator[tuple[Words, str | None]]:
    """The option as (words, the non-terminal after them); the last non-terminal is None and its words may be none."""
    words: list[str] = []
    for symbol in option.body:
        if isinstance(symbol, NonTerminal):
            yield tuple(words), symbol.name
            words = []
        else:
            words.append(symbol)
    yield tuple(words), None


@dataclass
class Derivable:
    """What a grammar's rules can hold: sorted clause and action numbers, and each run (state, words) -> (state,
    clauses) they take."""

    clauses: tuple[int, ...] = ()
    actions: tuple[int, ...] = ()
    runs: dict[tuple[int, Words], tuple[int, frozenset[int]]] = field(default_factory=dict)


class _Derivation:
    """The fixed point behind `derive`: ends[name, state] grows until nothing changes."""

    def __init__(self, productions: dict[str, Production], automaton: PhraseAutomaton) -> None:
        self.productions, self.automaton = productions, automaton
        self.ends: dict[tuple[str, int], set[int]] = {}
        self.users: dict[tuple[str, int], set[tuple[str, int]]] = defaultdict(set)
        self.todo: list[tuple[str, int]] = []
        self.runs: dict[tuple[int, Words], tuple[int, frozenset[int]]] = {}
        self.work = 0

    def solve(self, start: str) -> set[int]:
        goal = (start, CONDITION)
        self.meet(goal)
        while self.todo:
            pair = self.todo.pop()
            found = {end for option in self.productions[pair[0]].options for end in self.through(option, pair)}
            if not found <= self.ends[pair]:
                self.ends[pair] |= found
                self.todo.extend(self.users[pair])
        return self.ends[goal]

    def meet(self, pair: tuple[str, int]) -> None:
        if pair not in self.ends:
            self.ends[pair] = set()
            self.todo.append(pair)

    def through(self, option: Option, user: tuple[str, int]) -> set[int]:
        """The states after the option when it is begun in the user's state, as far as known by now."""
        states = {user[1]}
        for words, name in segments(option):
            self.work += len(states) + len(words)
            if self.work > MAX_WORK:
                raise InputError(f"line {option.line}: the grammar is too intricate to check; use fewer options")
            states = {self.run(state, words, option.line) for state in states}
            if name is not None:
                pairs = [(name, state) for state in states]
                for pair in pairs:
                    self.meet(pair)
                    self.users[pair].add(user)
                states = set().union(*(self.ends[pair] for pair in pairs))
        return states

    def run(self, state: int, words: Words, line: int) -> int:
        key = (state, words)
        if key not in self.runs:
            self.work += len(words)
            try:
                self.runs[key] = self.automaton.run(state, words)
            except InputError as error:
                raise InputError(f"line {line}: {error}") from None
        return self.runs[key][0]


def derive(productions: dict[str, Production], start: str, vocabulary: Vocabulary) -> Derivable:
    """Everything that rules derived from `start` can hold. Raises InputError, naming line, word and the words that
    exist, if some derivable text is no rule of known clauses and one known action."""
    reader = automaton(vocabulary)
    derivation = _Derivation(productions, reader)
    ends = derivation.solve(start)
    line = productions[start].line
    for state in sorted(ends):
        if state not in reader.action:
            problem = reader.complaint(state, "")
            raise InputError(f"line {line}: <{start}> must derive 'condition => action', but {problem}")
    clauses = {clause for _, done in derivation.runs.values() for clause in done}
    actions = {reader.action[state] for state in ends}
    return Derivable(tuple(sorted(clauses)), tuple(sorted(actions)), derivation.runs)
