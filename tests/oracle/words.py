"""What the numbers of the grammar's clauses and actions stand for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slcs2_jax.grammar.vocabulary import JAMMER_RANGE, LEFT, NO_ACTION, PAPER, Action

# Clauses.
PACKET_HELD, NO_PACKET_HELD = PAPER.parse_clause("packet held"), PAPER.parse_clause("no packet held")
NODE_IN_REACH, NO_NODE_IN_REACH = PAPER.parse_clause("node in reach"), PAPER.parse_clause("no node in reach")
NOISE = tuple(PAPER.noise_clause(channel) for channel in range(3))
OPERANDS = JAMMER_RANGE  # right-hand sides of comparisons but the jammer's range: d_so, d_si, d_c, d_th, net
COMPARE = tuple(PAPER.distance_clause(left, 0, 0) for left in range(len(LEFT)))  # the first; operator by operator
COMPARE_JAMMER = tuple(PAPER.distance_clause(left, 0, JAMMER_RANGE) for left in range(len(LEFT)))
SPLIT = COMPARE[3]  # clauses from here on stand in the second word; no left side's comparisons are cut
CLAUSES = NOISE[-1] + 1

# Actions.
KINDS = ("move", "collect", "send")
MOVE, COLLECT, SEND = range(len(KINDS))


def _column(value: Callable[[Action], int]) -> np.ndarray:
    """One fact about every action, by number; -1 where there is no action."""
    column = np.full(NO_ACTION + 1, -1)
    column[: len(PAPER.actions)] = [value(action) for action in PAPER.actions]
    return column


KIND = _column(lambda action: KINDS.index(action.kind))
DIRECTION = _column(lambda action: action.direction)
TARGET = _column(lambda action: action.target)
CHANNEL = _column(lambda action: action.channel)
POWER = _column(lambda action: action.power)
