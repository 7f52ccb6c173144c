"""What an agent can observe and do: the clauses and actions, their numbers and their words.

This is the contract between the rules and the swarm (paper, Appendix A as `docs/model.md` reads it). Within one
vocabulary a number means one clause or action; a mask holds clause k as bit k % 32 of word k // 32. Numbers never leave
the program: files say rules in words. The paper's parts come first and users' own last, so that bringing one changes
no number of the others. Text leaves the first channel and full power unsaid (`send to si` is the first channel at full
power); parsing also takes them said.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.registry import KINDS

CHANNELS = (1, 6, 11)  # the paper's
POWERS = ("half", "full")
HALF, FULL = range(len(POWERS))
LEFT = ("d_so", "d_si", "d_c", "d_sink", "d_source")
OPERATORS = ("<", ">", "=")
RIGHT = ("d_so", "d_si", "d_c", "d_th", "net", "xi")
JAMMER_RANGE = RIGHT.index("xi")
DIRECTIONS = ("toward", "away", "orbit")
TOWARD, AWAY, ORBIT = range(len(DIRECTIONS))
MOVE_TARGETS = ("so", "si", "c", "source", "sink", "jammer", "obstacle")
SO, SI, C, SOURCE, SINK, JAMMER, OBSTACLE = range(len(MOVE_TARGETS))
SEND_TARGETS = MOVE_TARGETS[:5]

WORD_BITS = 32  # clauses to a word of a mask
NO_ACTION = 255  # what an agent does whose match set is empty; no action has this number
_PLAIN = {
    "packet": "packet held",
    "no_packet": "no packet held",
    "node": "node in reach",
    "no_node": "no node in reach",
}
_MOVE_WORDS = ("move toward", "move away from", "orbit")
_MOVE_SYNONYMS = {AWAY: "move away", ORBIT: "move orbit"}  # also understood: the words of the paper's table


@dataclass(frozen=True)
class Clause:
    """One condition. `kind` is noise, packet, no_packet, node, no_node, distance or own; the other fields are -1 where
    they mean nothing.

    left, operator, right index LEFT, OPERATORS, RIGHT; channel the vocabulary's channels; own its own clauses.
    """

    kind: str
    left: int = -1
    operator: int = -1
    right: int = -1
    channel: int = -1
    own: int = -1


@dataclass(frozen=True)
class Action:
    """One action. `kind` is move, collect, send or own; the other fields are -1 where they mean nothing.

    direction indexes DIRECTIONS; target MOVE_TARGETS and, behind them, the vocabulary's own targets (move), or
    SEND_TARGETS (send); channel the vocabulary's channels; power POWERS; own its own actions.
    """

    kind: str
    direction: int = -1
    target: int = -1
    channel: int = -1
    power: int = -1
    own: int = -1


Own = tuple[tuple[str, Any], ...]  # users' parts: words, and what was registered for them


@dataclass(frozen=True)
class Vocabulary:
    """Every clause and action of a swarm with these channels and these parts of users' own."""

    channels: tuple[int, ...] = CHANNELS
    own_clauses: Own = ()
    own_targets: Own = ()
    own_actions: Own = ()
    clauses: tuple[Clause, ...] = field(init=False, repr=False, compare=False)
    actions: tuple[Action, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "clauses", tuple(self._all_clauses()))
        object.__setattr__(self, "actions", tuple(self._all_actions()))
        if len(self.actions) > NO_ACTION:
            raise InputError(
                f"actions: {len(self.actions)} in all; accepted are {NO_ACTION}: fewer channels or plug-ins"
            )
        for kind, numbers, phrases in (
            ("clause", self._clause_numbers, self.clause_phrases),
            ("action", self._action_numbers, self.action_phrases),
        ):
            if len(numbers) < sum(map(len, phrases)):
                said = [split_words(phrase) for every in phrases for phrase in every]
                twice = next(words for words in said if said.count(words) > 1)
                raise InputError(f"{kind} {quote(' '.join(twice))}: is there twice; accepted are words of its own")

    @classmethod
    def current(cls, channels: Sequence[int] = CHANNELS) -> Vocabulary:
        """The vocabulary of these channels and of all parts that are registered now."""
        clauses, targets, actions = (
            tuple((name, KINDS[kind].get(name)) for name in KINDS[kind].own())
            for kind in ("clause", "move target", "action")
        )
        return _made(tuple(channels), clauses, targets, actions)

    # Numbers. The order is that of the paper's parts: noise on the first channel, packets, nodes, distances, distances
    # to the jammer's range, noise on the others; moves, collects, sends.

    def _all_clauses(self) -> list[Clause]:
        distances = [
            Clause("distance", left, operator, right)
            for rights in (range(JAMMER_RANGE), (JAMMER_RANGE,))
            for left in range(len(LEFT))
            for operator in range(len(OPERATORS))
            for right in rights
        ]
        noise = [Clause("noise", channel=channel) for channel in range(len(self.channels))]
        own = [Clause("own", own=place) for place in range(len(self.own_clauses))]
        return [noise[0], *map(Clause, _PLAIN), *distances, *noise[1:], *own]

    def _all_actions(self) -> list[Action]:
        directions, known = range(len(DIRECTIONS)), len(MOVE_TARGETS)
        targets = range(known, known + len(self.own_targets))
        settings = [(channel, power) for channel in range(len(self.channels)) for power in range(len(POWERS))]
        return [
            *(Action("move", direction, target) for direction in directions for target in range(known)),
            *(Action("collect", channel=channel, power=power) for channel, power in settings),
            *(
                Action("send", target=target, channel=channel, power=power)
                for target in range(len(SEND_TARGETS))
                for channel, power in settings
            ),
            *(Action("move", direction, target) for direction in directions for target in targets),
            *(Action("own", own=place) for place in range(len(self.own_actions))),
        ]

    @cached_property
    def words(self) -> int:
        """Words of a mask that holds every clause."""
        return -(-len(self.clauses) // WORD_BITS)

    @property
    def settings(self) -> int:
        """How many pairs of a channel and a power there are."""
        return len(self.channels) * len(POWERS)

    @property
    def first_collect(self) -> int:
        """Number of the first action that collects; those before it move."""
        return len(DIRECTIONS) * len(MOVE_TARGETS)

    @property
    def first_send(self) -> int:
        """Number of the first action that sends."""
        return self.first_collect + self.settings

    @property
    def first_own(self) -> int:
        """Number of the first action that users brought: moves around their targets, then their actions."""
        return self.first_send + len(SEND_TARGETS) * self.settings

    def noise_clause(self, channel: int) -> int:
        """Number of the clause "noise on channels[channel] is at most P_rs"."""
        return self.clauses.index(Clause("noise", channel=channel))

    def distance_clause(self, left: int, operator: int, right: int) -> int:
        """Number of the clause LEFT[left] OPERATORS[operator] RIGHT[right]."""
        return self.clauses.index(Clause("distance", left, operator, right))

    def move_action(self, direction: int, target: int) -> int:
        """Number of the move in DIRECTIONS[direction] with respect to a target."""
        return self.actions.index(Action("move", direction, target))

    def collect_action(self, channel: int = 0, power: int = FULL) -> int:
        """Number of "collect from source" on channels[channel] at POWERS[power]."""
        return self.first_collect + channel * len(POWERS) + power

    def send_action(self, target: int, channel: int = 0, power: int = FULL) -> int:
        """Number of "send to SEND_TARGETS[target]" on channels[channel] at POWERS[power]."""
        return self.first_send + target * self.settings + channel * len(POWERS) + power

    # Words.

    @cached_property
    def clause_phrases(self) -> tuple[tuple[str, ...], ...]:
        """How each clause may be said; the first is how it is printed."""
        return tuple(tuple(self._clause_phrases(clause)) for clause in self.clauses)

    @cached_property
    def action_phrases(self) -> tuple[tuple[str, ...], ...]:
        """How each action may be said; the first is how it is printed."""
        return tuple(tuple(self._action_phrases(action)) for action in self.actions)

    @cached_property
    def targets(self) -> tuple[str, ...]:
        """What a move can be toward, away from or around."""
        return (*MOVE_TARGETS, *(name for name, _ in self.own_targets))

    def _clause_phrases(self, clause: Clause) -> list[str]:
        if clause.kind == "own":
            return [self.own_clauses[clause.own][0]]
        if clause.kind == "distance":
            return [f"{LEFT[clause.left]} {OPERATORS[clause.operator]} {RIGHT[clause.right]}"]
        if clause.kind == "noise":
            said = f"noise on {self.channels[clause.channel]} <= P_rs"
            return ["NI <= P_rs", said] if clause.channel == 0 else [said]
        return [_PLAIN[clause.kind]]

    def _action_phrases(self, action: Action) -> list[str]:
        if action.kind == "own":
            return [self.own_actions[action.own][0]]
        if action.kind == "move":
            starts = [_MOVE_WORDS[action.direction]]
            if action.direction in _MOVE_SYNONYMS:
                starts.append(_MOVE_SYNONYMS[action.direction])
            return [f"{start} {self.targets[action.target]}" for start in starts]
        start = "collect from source" if action.kind == "collect" else f"send to {SEND_TARGETS[action.target]}"
        channel, power = f" on {self.channels[action.channel]}", f" at {POWERS[action.power]} power"
        channels = ["", channel] if action.channel == 0 else [channel]
        powers = ["", power] if action.power == FULL else [power]
        return [start + on + at for on in channels for at in powers]

    @cached_property
    def _clause_numbers(self) -> dict[tuple[str, ...], int]:
        return {split_words(phrase): k for k, phrases in enumerate(self.clause_phrases) for phrase in phrases}

    @cached_property
    def _action_numbers(self) -> dict[tuple[str, ...], int]:
        return {split_words(phrase): k for k, phrases in enumerate(self.action_phrases) for phrase in phrases}

    @property
    def clause_names(self) -> str:
        """All clauses in a line, for messages."""
        own = [name for name, _ in self.own_clauses]
        noise = f"noise on {'|'.join(map(str, self.channels))} <= P_rs"
        distances = f"{'|'.join(LEFT)} {'|'.join(OPERATORS)} {'|'.join(RIGHT)}"
        return ", ".join([*_PLAIN.values(), "NI <= P_rs", noise, distances, *own])

    @property
    def action_names(self) -> str:
        """All actions in a line, for messages."""
        own = [name for name, _ in self.own_actions]
        moves = f"{'|'.join(_MOVE_WORDS)} {'|'.join(self.targets)}"
        sends = f"collect from source, send to {'|'.join(SEND_TARGETS)}"
        how = f"the last two with [on {'|'.join(map(str, self.channels))}] [at {'|'.join(POWERS)} power]"
        return ", ".join([moves, sends, how, *own])

    def clause_text(self, number: int) -> str:
        """The clause in words, e.g. `d_si < net`. Raises InputError for an unknown number."""
        return _lookup("clause", int(number), self.clause_phrases)

    def action_text(self, number: int) -> str:
        """The action in words, e.g. `send to si on 11`. Raises InputError for an unknown number (NO_ACTION has no
        words)."""
        return _lookup("action", int(number), self.action_phrases)

    def parse_clause(self, text: str) -> int:
        """The number of the clause so said. Raises InputError with the clauses that exist."""
        number = self._clause_numbers.get(split_words(text))
        if number is None:
            raise InputError(
                f"clause: {quote(text)} is not known; clauses are: {self.clause_names}; others come with plugins="
            )
        return number

    def parse_action(self, text: str) -> int:
        """The number of the action so said. Raises InputError with the actions that exist."""
        number = self._action_numbers.get(split_words(text))
        if number is None:
            raise InputError(
                f"action: {quote(text)} is not known; actions are: {self.action_names}; others come with plugins="
            )
        return number


_WORD = re.compile(r"=>|<=|[<>=&]|[^\s<>=&]+")


def split_words(text: str) -> tuple[str, ...]:
    """The words of a text; operators, `&` and `=>` are words of their own, with or without spaces around them."""
    return tuple(_WORD.findall(text))


def quote(text: object, limit: int = 60) -> str:
    """A text for an error message: quoted, on one line, printable, cut at `limit` characters."""
    shown = str(text)
    return ascii(shown if len(shown) <= limit else shown[:limit] + "...")


def _lookup(kind: str, number: int, table: tuple[tuple[str, ...], ...]) -> str:
    if not 0 <= number < len(table):
        raise InputError(f"{kind}: number {number} is not one of 0..{len(table) - 1}")
    return table[number][0]


@lru_cache(maxsize=64)  # a vocabulary's tables are made once for all who ask
def _made(channels: tuple[int, ...], clauses: Own, targets: Own, actions: Own) -> Vocabulary:
    return Vocabulary(channels, clauses, targets, actions)


PAPER = _made(CHANNELS, (), (), ())  # the paper's own
