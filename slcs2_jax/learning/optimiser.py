"""Steps of an optimiser of optax."""

from __future__ import annotations

from typing import Any

import jax


def stepped(optimiser: Any, gradient: Any, state: Any) -> tuple[Any, Any]:
    """What to add to the weights, and the optimiser's state afterwards.

    optax multiplies numbers of different types, here and there, which is an error where JAX is told to be strict.
    """
    with jax.numpy_dtype_promotion("standard"):
        change, state = optimiser.update(gradient, state)
    return change, state
