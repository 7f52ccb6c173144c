"""The remembered action sets in other forms, to start an episode from a state that came from elsewhere."""

from __future__ import annotations

import numpy as np

from tests.oracle.model import Params, State
from tests.oracle.strength import settle


def set_history(state: State, t: int) -> np.ndarray:
    """uint32[n, R]: bit k says whether the rule was in the action set of step t - 1 - k, t steps having been made."""
    n, memory, count = state.past_set.shape
    bits = np.zeros((n, count), np.uint32)
    for age in range(min(memory, t)):
        slot = (t - 1 - age) % memory
        for i in range(n):
            bits[i, state.past_set[i, slot, : state.past_size[i, slot]]] |= np.uint32(1 << age)
    return bits


def restore_history(state: State, t: int, bits: np.ndarray, rewards: np.ndarray) -> None:
    """Sets the remembered action sets of a state after t steps.

    bits uint32[n, R] as set_history returns them; rewards [n, L] with the newest first, 0 for a step without an action.
    """
    n, memory, _ = state.past_set.shape
    state.past_size[:] = 0
    state.past_credit[:] = 0.0
    for age in range(min(memory, t)):
        slot = (t - 1 - age) % memory
        state.past_credit[:, slot] = np.copysign(np.log10(np.abs(rewards[:, age]) + 1.0), rewards[:, age])
        for i in range(n):
            members = np.flatnonzero(bits[i] >> np.uint32(age) & np.uint32(1))
            state.past_set[i, slot, : len(members)] = members
            state.past_size[i, slot] = len(members)
    state.reward[:] = rewards[:, 0]


def credited_strength(state: State, params: Params, t: int) -> np.ndarray:
    """[n, R] strength after t steps with every reward so far credited, also to the remembered action sets."""
    strength = state.strength.copy()
    for i in range(len(strength)):
        settle(t, state.past_set[i], state.past_size[i], state.past_credit[i], params.trace_decay, strength[i])
    return strength


def restore_strength(state: State, params: Params, t: int, credited: np.ndarray) -> None:
    """Sets the strength of a state whose remembered action sets are set already; the inverse of credited_strength."""
    state.strength[:] = 0.0
    state.strength[:] = credited - credited_strength(state, params, t)
