"""The radio: log-distance path loss, shadowing, walls, signal to interference plus noise ratio (spec section 3)."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.model import Radio, log_distance_reach

DB_TO_LOG2 = float(np.log2(10.0) / 10.0)


def milliwatts(dbm: Any) -> Any:
    """Power in mW of a level in dBm, a number or a traced array."""
    return 10.0 ** (dbm / 10.0)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class RadioParameters:
    """The radio in the units of the step: powers in mW, gains as powers of two. Every leaf is a float32 scalar."""

    gain: jax.Array  # log2 of the mW received at the reference distance, without shadowing
    slope: jax.Array  # log2 of the loss per log2 of the squared distance: half the path-loss exponent
    floor: jax.Array  # m2, squared reference distance: nearer counts as there
    shadowing: jax.Array  # log2 units, standard deviation
    wall: jax.Array  # log2 units per wall
    noise: jax.Array  # mW
    sensitivity: jax.Array  # mW, P_rs
    threshold: jax.Array  # least SINR, a ratio
    half_power: jax.Array  # ratio of half to full power
    network_range: jax.Array  # m, net

    @classmethod
    def of(cls, radio: Radio, **changed: Any) -> RadioParameters:
        """Convert settings in dB and dBm.

        `changed` are settings of the radio by name in place of its own: traced arrays too, so that a program compiled
        once serves every value; what derives from them, the network range above all, follows.
        """
        said: Any = SimpleNamespace(**(vars(radio) | changed))
        d0 = said.reference_distance
        values = {
            "gain": (said.power_dbm - said.reference_loss_db) * DB_TO_LOG2 + said.path_loss_exponent * _log2(d0),
            "slope": said.path_loss_exponent / 2,
            "floor": d0**2,
            "shadowing": said.shadowing_db * DB_TO_LOG2,
            "wall": said.wall_loss_db * DB_TO_LOG2,
            "noise": milliwatts(said.noise_dbm),
            "sensitivity": milliwatts(said.receive_threshold_dbm),
            "threshold": milliwatts(said.sinr_threshold_db),
            "half_power": milliwatts(said.half_power_db),
            "network_range": log_distance_reach(said),
        }
        return cls(**{name: jnp.float32(value) for name, value in values.items()})


def _log2(value: Any) -> Any:
    return jnp.log2(value) if isinstance(value, jax.Array) else float(np.log2(value))


def received_power(
    squared_distance: jax.Array, walls: jax.Array, shadow: jax.Array, radio: RadioParameters
) -> jax.Array:
    """Power received over each link from a sender at full power (spec 3: P_t - PL(d) - walls * L_w + X).

    Args:
        squared_distance: float32 [...], m2.
        walls: float32 [...] or scalar, walls that the link crosses.
        shadow: float32 [...], standard normal deviates.
        radio: parameters.

    Returns:
        float32 [...], mW.
    """
    loss = radio.slope * jnp.log2(jnp.maximum(squared_distance, radio.floor))
    return jnp.exp2(radio.gain - loss - radio.wall * walls + radio.shadowing * shadow)


def decodable(signal: jax.Array, disturbance: jax.Array, radio: RadioParameters) -> jax.Array:
    """Whether a signal is received: power >= P_rs and SINR >= threshold (spec 3).

    Args:
        signal: float32 [...], mW.
        disturbance: float32 [...], mW, every other signal on the channel without the thermal noise.
        radio: parameters.

    Returns:
        bool [...].
    """
    return (signal >= radio.sensitivity) & (signal >= radio.threshold * (radio.noise + disturbance))
