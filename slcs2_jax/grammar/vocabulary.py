"""What an agent can observe and do: the clauses and actions, their numbers and their words.

This is the contract between the rules and the swarm (paper, Appendix A as read in spec section 5). Numbers are fixed:
masks and actions in run folders mean these. `CLAUSES[k]` and `ACTIONS[k]` say what number k stands for; the text
functions are each other's inverse. Text leaves channel 1 and full power unsaid (`send to si` is channel 1 at full
power); parsing also takes them said.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from slcs2_jax.config.errors import InputError

CHANNELS = (1, 6, 11)
POWERS = ("half", "full")
HALF, FULL = 0, 1
LEFT = ("d_so", "d_si", "d_c", "d_sink", "d_source")
OPERATORS = ("<", ">", "=")
RIGHT = ("d_so", "d_si", "d_c", "d_th", "net", "xi")
JAMMER_RANGE = RIGHT.index("xi")
DIRECTIONS = ("toward", "away", "orbit")
TOWARD, AWAY, ORBIT = range(len(DIRECTIONS))
MOVE_TARGETS = ("so", "si", "c", "source", "sink", "jammer", "obstacle")
SO, SI, C, SOURCE, SINK, JAMMER, OBSTACLE = range(len(MOVE_TARGETS))
SEND_TARGETS = MOVE_TARGETS[:5]

N_CLAUSES = 97
N_ACTIONS = 57
MASK_WORDS = 4  # 32 clauses to a word
NO_ACTION = 255

FIRST_DISTANCE, FIRST_JAMMER_DISTANCE, FIRST_NOISE = 5, 80, 95
FIRST_COLLECT, FIRST_SEND = 21, 27


@dataclass(frozen=True)
class Clause:
    """One condition. `kind` is noise, packet, no_packet, node, no_node or distance; the other fields are -1 where
    they mean nothing.

    left, operator, right index LEFT, OPERATORS, RIGHT; channel indexes CHANNELS.
    """

    kind: str
    left: int = -1
    operator: int = -1
    right: int = -1
    channel: int = -1


@dataclass(frozen=True)
class Action:
    """One action. `kind` is move, collect or send; the other fields are -1 where they mean nothing.

    direction indexes DIRECTIONS; target indexes MOVE_TARGETS (move) or SEND_TARGETS (send); channel CHANNELS; power
    POWERS.
    """

    kind: str
    direction: int = -1
    target: int = -1
    channel: int = -1
    power: int = -1


def noise_clause(channel: int) -> int:
    """Number of the clause "noise on CHANNELS[channel] is at most P_rs"."""
    return 0 if channel == 0 else FIRST_NOISE + channel - 1


def distance_clause(left: int, operator: int, right: int) -> int:
    """Number of the clause LEFT[left] OPERATORS[operator] RIGHT[right]."""
    if right == JAMMER_RANGE:
        return FIRST_JAMMER_DISTANCE + left * 3 + operator
    return FIRST_DISTANCE + (left * 3 + operator) * 5 + right


def move_action(direction: int, target: int) -> int:
    """Number of the move in DIRECTIONS[direction] with respect to MOVE_TARGETS[target]."""
    return direction * 7 + target


def collect_action(channel: int = 0, power: int = FULL) -> int:
    """Number of "collect from source" on CHANNELS[channel] at POWERS[power]."""
    return FIRST_COLLECT + channel * 2 + power


def send_action(target: int, channel: int = 0, power: int = FULL) -> int:
    """Number of "send to SEND_TARGETS[target]" on CHANNELS[channel] at POWERS[power]."""
    return FIRST_SEND + target * 6 + channel * 2 + power


def _all_clauses() -> tuple[Clause, ...]:
    found = {1: Clause("packet"), 2: Clause("no_packet"), 3: Clause("node"), 4: Clause("no_node")}
    for channel in range(len(CHANNELS)):
        found[noise_clause(channel)] = Clause("noise", channel=channel)
    for left in range(len(LEFT)):
        for operator in range(len(OPERATORS)):
            for right in range(len(RIGHT)):
                found[distance_clause(left, operator, right)] = Clause("distance", left, operator, right)
    return tuple(found[k] for k in range(N_CLAUSES))


def _all_actions() -> tuple[Action, ...]:
    found = {}
    for direction in range(len(DIRECTIONS)):
        for target in range(len(MOVE_TARGETS)):
            found[move_action(direction, target)] = Action("move", direction, target)
    for channel in range(len(CHANNELS)):
        for power in range(len(POWERS)):
            found[collect_action(channel, power)] = Action("collect", channel=channel, power=power)
            for target in range(len(SEND_TARGETS)):
                number = send_action(target, channel, power)
                found[number] = Action("send", target=target, channel=channel, power=power)
    return tuple(found[k] for k in range(N_ACTIONS))


CLAUSES = _all_clauses()
ACTIONS = _all_actions()

_PLAIN = {
    "packet": "packet held",
    "no_packet": "no packet held",
    "node": "node in reach",
    "no_node": "no node in reach",
}
_MOVE_WORDS = ("move toward", "move away from", "orbit")
_EXTRA_MOVE_WORDS = {1: "move away", 2: "move orbit"}  # also understood: the words of the paper's table


def _clause_phrases(clause: Clause) -> list[str]:
    """How the clause may be said; the first is how it is printed."""
    if clause.kind == "distance":
        return [f"{LEFT[clause.left]} {OPERATORS[clause.operator]} {RIGHT[clause.right]}"]
    if clause.kind == "noise":
        said = f"noise on {CHANNELS[clause.channel]} <= P_rs"
        return ["NI <= P_rs", said] if clause.channel == 0 else [said]
    return [_PLAIN[clause.kind]]


def _action_phrases(action: Action) -> list[str]:
    """How the action may be said; the first is how it is printed."""
    if action.kind == "move":
        target = MOVE_TARGETS[action.target]
        starts = [_MOVE_WORDS[action.direction]]
        if action.direction in _EXTRA_MOVE_WORDS:
            starts.append(_EXTRA_MOVE_WORDS[action.direction])
        return [f"{start} {target}" for start in starts]
    start = "collect from source" if action.kind == "collect" else f"send to {SEND_TARGETS[action.target]}"
    channel, power = f" on {CHANNELS[action.channel]}", f" at {POWERS[action.power]} power"
    channels = ["", channel] if action.channel == 0 else [channel]
    powers = ["", power] if action.power == FULL else [power]
    return [start + on + at for on in channels for at in powers]


CLAUSE_PHRASES = tuple(tuple(_clause_phrases(clause)) for clause in CLAUSES)
ACTION_PHRASES = tuple(tuple(_action_phrases(action)) for action in ACTIONS)

CLAUSE_NAMES = (
    f"{', '.join(_PLAIN.values())}, NI <= P_rs, noise on {'|'.join(map(str, CHANNELS))} <= P_rs, "
    f"{'|'.join(LEFT)} {'|'.join(OPERATORS)} {'|'.join(RIGHT)}"
)
ACTION_NAMES = (
    f"{'|'.join(_MOVE_WORDS)} {'|'.join(MOVE_TARGETS)}, collect from source, send to {'|'.join(SEND_TARGETS)}, "
    f"the last two with [on {'|'.join(map(str, CHANNELS))}] [at {'|'.join(POWERS)} power]"
)

_WORD = re.compile(r"=>|<=|[<>=&]|[^\s<>=&]+")


def split_words(text: str) -> tuple[str, ...]:
    """The words of a text; operators, `&` and `=>` are words of their own, with or without spaces around them."""
    return tuple(_WORD.findall(text))


_CLAUSE_NUMBERS = {split_words(phrase): k for k, phrases in enumerate(CLAUSE_PHRASES) for phrase in phrases}
_ACTION_NUMBERS = {split_words(phrase): k for k, phrases in enumerate(ACTION_PHRASES) for phrase in phrases}


def quote(text: object, limit: int = 60) -> str:
    """A text for an error message: quoted, on one line, printable, cut at `limit` characters."""
    shown = str(text)
    return ascii(shown if len(shown) <= limit else shown[:limit] + "...")


def _lookup(kind: str, number: int, table: tuple[tuple[str, ...], ...]) -> str:
    if not 0 <= number < len(table):
        raise InputError(f"{kind}: number {number} is not one of 0..{len(table) - 1}")
    return table[number][0]


def clause_text(number: int) -> str:
    """The clause in words, e.g. `d_si < net`. Raises InputError for an unknown number."""
    return _lookup("clause", int(number), CLAUSE_PHRASES)


def action_text(number: int) -> str:
    """The action in words, e.g. `send to si on 11`. Raises InputError for an unknown number (NO_ACTION has no
    words)."""
    return _lookup("action", int(number), ACTION_PHRASES)


def parse_clause(text: str) -> int:
    """The number of the clause so said. Raises InputError with the clauses that exist."""
    number = _CLAUSE_NUMBERS.get(split_words(text))
    if number is None:
        raise InputError(f"clause: {quote(text)} is not known; clauses are: {CLAUSE_NAMES}")
    return number


def parse_action(text: str) -> int:
    """The number of the action so said. Raises InputError with the actions that exist."""
    number = _ACTION_NUMBERS.get(split_words(text))
    if number is None:
        raise InputError(f"action: {quote(text)} is not known; actions are: {ACTION_NAMES}")
    return number
