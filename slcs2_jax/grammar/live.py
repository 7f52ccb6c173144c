"""Which rules can hold at all: those whose clauses contradict each other never do.

A condition says of distances which is less than which. With what is known of all of them (nobody known is closer than
the closest; what d_th and the network range are) that is a graph; where a way through it leads back to its start and
one of its steps is "less than", no swarm is ever in such a state. Clauses of users' own are taken to hold with any.
N = rules, C = clauses, V = operands and the bounds of what equals a constant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.errors import refuse
from slcs2_jax.config.settings import Settings
from slcs2_jax.grammar.decode import random_rules
from slcs2_jax.grammar.grammar import Grammar
from slcs2_jax.grammar.vocabulary import LEFT, OPERATORS, RIGHT, Vocabulary

_MOST_DRAWS = 100
_APART = 0.1  # m, more than rounding: constants nearer to each other are not told apart
_LESS, _GREATER, _EQUAL = range(len(OPERATORS))
# Never greater: the closest is at most as far as anybody, and who is on the side of a node at most as far as the node.
_AT_MOST = (
    ("d_c", "d_so"), ("d_c", "d_si"), ("d_c", "d_sink"), ("d_c", "d_source"), ("d_si", "d_sink"), ("d_so", "d_source"),
)  # fmt: skip
_CONSTANTS = ("d_th", "net")
_NODES = (*LEFT, "xi", *(f"{name}{end}" for name in _CONSTANTS for end in ("", " low", " high")))
_OPPOSITES = (("packet", "no_packet"), ("node", "no_node"))


@dataclass(frozen=True)
class Bounds:
    """What is known of distances: d_th and the network range (m), and how far off `=` may be (m, and a share)."""

    threshold: float
    network: float
    speed: float
    tolerance: float

    @classmethod
    def of(cls, settings: Settings) -> Bounds:
        """Those of a swarm."""
        swarm = settings.swarm
        return cls(swarm.distance_threshold, settings.radio.network_range, swarm.speed, swarm.tolerance)

    def values(self) -> dict[str, float]:
        """Of the constants, and of the least and the greatest that equals them, m."""
        found: dict[str, float] = {}
        for name, value in zip(_CONSTANTS, (self.threshold, self.network), strict=True):
            off = max(self.speed, self.tolerance * value)
            found |= {name: value, f"{name} low": value - off, f"{name} high": value + off}
        return found


def live_rules(
    grammar: Grammar, count: int, rng: np.random.Generator, *, codons: int, bounds: Bounds
) -> tuple[NDArray[np.uint32], NDArray[np.uint8]]:
    """`count` random rules that can hold: mask uint32[count, W], action uint8[count]; see `random_rules`.

    As many are drawn again as cannot. Raises InputError if hardly any can.
    """
    masks, actions, missing = [], [], count
    for _ in range(_MOST_DRAWS):
        mask, action = random_rules(grammar, missing, rng, codons=codons)
        alive = can_hold(mask, grammar.vocabulary, bounds)
        masks.append(mask[alive])
        actions.append(action[alive])
        missing -= int(alive.sum())
        if not missing:
            return np.concatenate(masks), np.concatenate(actions)
    raise refuse("rules.distinct", True, f"a grammar of which most rules can hold; of grammar={grammar.name} few can")


def can_hold(mask: NDArray[np.uint32], vocabulary: Vocabulary, bounds: Bounds) -> NDArray[np.bool_]:
    """bool[N]: False for rules that no state of a swarm satisfies; of rules given by their masks uint32[N, W]."""
    bits = np.unpackbits(np.ascontiguousarray(mask, "<u4").view(np.uint8), axis=-1, bitorder="little")
    said = bits[:, : len(vocabulary.clauses)].astype(np.float32)
    less, at_most, opposites = _meaning(vocabulary, bounds)
    count = len(_NODES)
    strict = (said @ less).reshape(-1, count, count) > 0
    way = strict | ((said @ at_most).reshape(-1, count, count) > 0) | np.eye(count, dtype=bool)
    known_less, known_at_most = _known(bounds)
    strict, way = strict | known_less, way | known_less | known_at_most
    for middle in range(count):  # Warshall's closure
        way |= way[:, :, middle, None] & way[:, None, middle, :]
    alive = np.logical_not((strict & way.swapaxes(1, 2)).any(axis=(1, 2)))  # a way back from the greater to the less
    for one, other in opposites:
        alive &= ~((said[:, one] > 0) & (said[:, other] > 0))
    return np.asarray(alive)


@lru_cache(maxsize=16)
def _meaning(vocabulary: Vocabulary, bounds: Bounds) -> tuple[Any, Any, tuple[tuple[int, int], ...]]:
    """What each clause says: float32[C, V * V] "less than" and "at most"; and pairs of clauses that are opposites."""
    count, place = len(_NODES), {name: number for number, name in enumerate(_NODES)}
    less, at_most = np.zeros((2, len(vocabulary.clauses), count, count), np.float32)
    for number, clause in enumerate(vocabulary.clauses):
        if clause.kind != "distance":
            continue
        left, right = LEFT[clause.left], RIGHT[clause.right]
        if clause.operator == _LESS:
            less[number, place[left], place[right]] = 1
        elif clause.operator == _GREATER:
            less[number, place[right], place[left]] = 1
        elif right in _CONSTANTS:
            at_most[number, place[left], place[f"{right} high"]] = 1
            at_most[number, place[f"{right} low"], place[left]] = 1
    kinds = [clause.kind for clause in vocabulary.clauses]
    pairs = tuple((kinds.index(one), kinds.index(other)) for one, other in _OPPOSITES)
    return less.reshape(-1, count * count), at_most.reshape(-1, count * count), pairs


@lru_cache(maxsize=16)
def _known(bounds: Bounds) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """bool[V, V] what is less than, and at most as great as, what: in every state."""
    count, place = len(_NODES), {name: number for number, name in enumerate(_NODES)}
    less, at_most = np.zeros((2, count, count), bool)
    for one, other in _AT_MOST:
        at_most[place[one], place[other]] = True
    values = bounds.values()
    for one, low in values.items():
        for other, high in values.items():
            less[place[one], place[other]] = low < high - _APART
    return less, at_most
