"""The truth of every clause that a rule may state (paper, Appendix A as `docs/model.md` reads it)."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import OPERATORS, WORD_BITS
from slcs2_jax.swarm.state import SwarmParameters
from slcs2_jax.swarm.view import View, checked
from slcs2_jax.world.geometry import SLACK
from slcs2_jax.world.stored import kept


def truth(view: View, language: Language) -> jax.Array:
    """Bit k % 32 of word k // 32 tells whether clause k holds: uint32 [W, n, ...]; none for agents that are not able.

    Of users' clauses only those are computed that a rule of the batch can state.
    """
    state, vocabulary = view.state, language.vocabulary
    holds: dict[str, Any] = {
        "packet": state.holding,
        "no_packet": ~state.holding,
        "node": view.node_heard,
        "no_node": ~view.node_heard,
        "noise": state.interference <= view.radio.sensitivity,
        "distance": _compare(view.left, view.right, view.swarm),
    }
    words = [jnp.zeros(state.holding.shape, jnp.uint32)] * vocabulary.words
    for number, clause in enumerate(vocabulary.clauses):
        if clause.kind == "noise":
            if clause.channel >= state.interference.shape[0]:
                continue  # a channel that is not simulated, because no rule of the batch names it
            true = holds["noise"][clause.channel]
        elif clause.kind == "distance":
            true = holds["distance"][clause.left, clause.operator, clause.right]
        elif clause.kind == "own":
            if number not in language.own_clauses:
                continue
            name, part = vocabulary.own_clauses[clause.own]
            true = checked("clause", name, part(view), state.holding, bool)
        else:
            true = holds[clause.kind]
        word, bit = divmod(number, WORD_BITS)
        words[word] |= jnp.where(true, np.uint32(1 << bit), np.uint32(0))
    return jnp.stack([kept(jnp.where(view.able, word, np.uint32(0))) for word in words])


def _compare(
    left: tuple[jax.Array, ...], right: tuple[jax.Array, ...], parameters: SwarmParameters
) -> dict[tuple[int, int, int], jax.Array]:
    """Truth of every distance clause (left operand, operator, right operand): bool [n, ...] each.

    An undefined operand makes its clause false under every operator. Equality has a tolerance of one step of motion or
    a share of the right operand, whichever is more, and does not exclude ``<`` and ``>``, which need a difference
    beyond rounding: the same distance may be computed in two ways.
    """
    holds = {}
    for j, b in enumerate(right):
        tolerance = jnp.maximum(parameters.speed, parameters.tolerance * b) + np.float32(SLACK)
        for i, a in enumerate(left):
            defined = (a < jnp.inf) & (b < jnp.inf)
            holds[i, 0, j] = a < b - np.float32(SLACK)
            holds[i, 1, j] = a > b + np.float32(SLACK)
            holds[i, 2, j] = (a <= b + tolerance) & (a >= b - tolerance)
            for operator in range(len(OPERATORS)):
                holds[i, operator, j] &= defined
    return holds
