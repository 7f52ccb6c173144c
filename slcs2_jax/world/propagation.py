"""Mean received power over distance and walls (model section 3).

A propagation model is a pytree of parameters with three functions; a user's own is a class of this form registered as
`register("propagation", name)`. Distances in m, levels in powers of two of mW: a step needs no logarithm of a power.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.radio import log_distance_reach

DB_TO_LOG2 = float(np.log2(10.0) / 10.0)


class Propagation(Protocol):
    """What a propagation model offers."""

    @classmethod
    def of(cls, radio: Any) -> Propagation:
        """The parameters from the settings `radio`, or from anything with its attributes, numbers or traced arrays."""
        ...

    @staticmethod
    def reach(radio: Any) -> Any:
        """net, m: the distance at which the mean received power equals P_rs, without walls."""
        ...

    def level(self, squared_distance: jax.Array, walls: jax.Array) -> jax.Array:
        """log2 of the mW received at full power: float32, of squared distances (m2) and counts of walls."""
        ...


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class LogDistance:
    """Log-distance path loss with a loss per wall: P_t - PL0 - 10 gamma log10(max(d, d0) / d0) - walls L_w.

    The paper's model (section on the radio; model 3); Rappaport, Wireless Communications (2nd ed.), sections 4.9 and
    4.11.5. Every leaf is a float32 scalar.
    """

    gain: jax.Array  # log2 of the mW received at the reference distance
    slope: jax.Array  # log2 of the loss per log2 of the squared distance: half the path-loss exponent
    floor: jax.Array  # m2, squared reference distance: nearer counts as there
    wall: jax.Array  # log2 units per wall

    @classmethod
    def of(cls, radio: Any) -> LogDistance:
        """Convert settings in dB and dBm."""
        d0, exponent = radio.reference_distance, radio.path_loss_exponent
        return cls(
            gain=jnp.float32((radio.power_dbm - radio.reference_loss_db) * DB_TO_LOG2 + exponent * _log2(d0)),
            slope=jnp.float32(exponent / 2),
            floor=jnp.float32(d0**2),
            wall=jnp.float32(radio.wall_loss_db * DB_TO_LOG2),
        )

    @staticmethod
    def reach(radio: Any) -> Any:
        """net, m."""
        return log_distance_reach(radio)

    def level(self, squared_distance: jax.Array, walls: jax.Array) -> jax.Array:
        """log2 of the mW received at full power, without fading."""
        loss = self.slope * jnp.log2(jnp.maximum(squared_distance, self.floor))
        return self.gain - loss - self.wall * walls


def _log2(value: Any) -> Any:
    return jnp.log2(value) if isinstance(value, jax.Array) else math.log2(value)
