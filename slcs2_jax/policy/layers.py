"""A small network, feed-forward or recurrent: pure functions of a dictionary of arrays, on any leading axes.

F figures in, H hidden, C remembered (0 without memory), A actions out. A network is
`{"dense": [{"w", "b"}, ...], "gru": {...}, "out": {"w", "b"}}`; one without memory has no "gru".
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

Network = dict[str, Any]


def initial(
    rng: np.random.Generator, figures: int, actions: int, *, hidden: tuple[int, ...], recurrent: int = 0
) -> Network:
    """A network drawn at random: orthogonal weights, and last ones so small that all actions are about as likely.

    Gains as Andrychowicz et al. (2021, arXiv 2006.05990) advise: sqrt 2 within, 0.01 at the end; no bias.

    Args:
        rng: to draw from.
        figures: F.
        actions: A, what the logits are of.
        hidden: widths of the layers, at least one.
        recurrent: C, units of a GRU behind them; 0 for none.
    """
    network: Network = {"dense": []}
    before = figures
    for width in hidden:
        network["dense"].append(layer(rng, before, width, np.sqrt(2)))
        before = width
    if recurrent:
        network["gru"] = {
            "input": np.concatenate([orthogonal(rng, before, recurrent) for _ in range(3)], axis=1),
            "carry": np.concatenate([orthogonal(rng, recurrent, recurrent) for _ in range(3)], axis=1),
            "bias": np.zeros(3 * recurrent, np.float32),
        }
        before = recurrent
    network["out"] = layer(rng, before, actions, 0.01)
    return network


def layer(rng: np.random.Generator, inputs: int, outputs: int, gain: float) -> dict[str, NDArray[np.float32]]:
    """A layer drawn at random: w float32 [inputs, outputs], b float32 [outputs]."""
    return {"w": orthogonal(rng, inputs, outputs, gain), "b": np.zeros(outputs, np.float32)}


def orthogonal(rng: np.random.Generator, rows: int, columns: int, gain: float = 1.0) -> NDArray[np.float32]:
    """A random matrix whose shorter side is orthonormal, times the gain: float32 (Saxe et al. 2014)."""
    drawn = rng.normal(size=(max(rows, columns), min(rows, columns)))
    q, r = np.linalg.qr(drawn)
    q = q * np.sign(np.diagonal(r))
    return (gain * (q if rows >= columns else q.T)).astype(np.float32)


def memory(network: Network) -> int:
    """C, how many numbers it remembers from step to step."""
    return network["gru"]["carry"].shape[0] if "gru" in network else 0


def forward(network: Network, carry: jax.Array, figures: jax.Array) -> tuple[jax.Array, jax.Array]:
    """One step.

    Args:
        network: see above.
        carry: float32 [..., C], zero in an episode's first step.
        figures: float32 [..., F].

    Returns:
        carry float32 [..., C], and what the last layer looks at, float32 [..., H].
    """
    hidden = figures
    for one in network["dense"]:
        hidden = jnp.tanh(hidden @ one["w"] + one["b"])
    if "gru" not in network:
        return carry, hidden
    carry = _gru(network["gru"], carry, hidden @ network["gru"]["input"] + network["gru"]["bias"])
    return carry, carry


def unrolled(network: Network, carry: jax.Array, figures: jax.Array) -> jax.Array:
    """Steps one after the other, none of which begins an episode but the first.

    Args:
        network: see above.
        carry: float32 [..., C], before the first step.
        figures: float32 [L, ..., F].

    Returns:
        What the last layer looks at in every step, float32 [L, ..., H].
    """
    if "gru" not in network:
        return forward(network, carry, figures)[1]

    def step(carry: jax.Array, figures: jax.Array) -> tuple[jax.Array, jax.Array]:
        return forward(network, carry, figures)

    return jax.lax.scan(step, carry, figures)[1]


def head(layer: dict[str, Any], hidden: jax.Array) -> jax.Array:
    """A last layer, without a function behind it: float32 [..., outputs]."""
    return hidden @ layer["w"] + layer["b"]


def apply(network: Network, carry: jax.Array, figures: jax.Array) -> tuple[jax.Array, jax.Array]:
    """One step as `policy.network.Network` asks for it: the carry, and the logits [..., A]."""
    carry, hidden = forward(network, carry, figures)
    return carry, head(network["out"], hidden)


def _gru(gru: dict[str, Any], carry: jax.Array, given: jax.Array) -> jax.Array:
    """A gated recurrent unit (Cho et al. 2014, arXiv 1406.1078), the reset gate behind the product.

    given: float32 [..., 3 C], what the input comes to for reset, update and candidate.
    """
    reset_given, update_given, candidate_given = jnp.split(given, 3, axis=-1)
    reset_kept, update_kept, candidate_kept = jnp.split(carry @ gru["carry"], 3, axis=-1)
    reset = jax.nn.sigmoid(reset_given + reset_kept)
    update = jax.nn.sigmoid(update_given + update_kept)
    candidate = jnp.tanh(candidate_given + reset * candidate_kept)
    return (np.float32(1) - update) * candidate + update * carry
