"""The radio: received power, signal to interference plus noise ratio (model section 3)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.radio import Radio
from slcs2_jax.config.registry import KINDS

_SAMPLE = 1024  # links on which a user's part is tried


def milliwatts(dbm: Any) -> Any:
    """Power in mW of a level in dBm, a number or a traced array."""
    return 10.0 ** (dbm / 10.0)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class RadioParameters:
    """The radio in the units of the step: powers in mW; propagation and fading with parameters of their own.

    Every leaf of this package's parts is a float32 scalar. `parts` are the classes of propagation and fading: JAX holds
    the structures of two registered dataclasses with as many leaves for equal, though their hashes differ, and would
    now and then run a program that was compiled for another part.
    """

    propagation: Any  # of `propagation.Propagation`
    fading: Any  # of `fading.Fading`
    noise: jax.Array  # mW
    sensitivity: jax.Array  # mW, P_rs
    threshold: jax.Array  # least SINR, a ratio
    half_power: jax.Array  # ratio of half to full power
    network_range: jax.Array  # m, net
    parts: tuple[type, type] = dataclasses.field(metadata={"static": True})

    @classmethod
    def of(cls, radio: Any) -> RadioParameters:
        """Convert settings in dB and dBm.

        `radio` are the settings, or anything with their attributes, of which numbers may be traced arrays: then a
        program compiled once serves every value, and what derives from them, the network range above all, follows.

        Raises InputError naming a user's part that gives wrong shapes, types or numbers.
        """
        parts = {kind: KINDS[kind].get(getattr(radio, kind)) for kind in ("propagation", "fading")}
        propagation, fading = parts["propagation"].of(radio), parts["fading"].of(radio)
        made = cls(
            propagation=propagation,
            fading=fading,
            noise=jnp.float32(milliwatts(radio.noise_dbm)),
            sensitivity=jnp.float32(milliwatts(radio.receive_threshold_dbm)),
            threshold=jnp.float32(milliwatts(radio.sinr_threshold_db)),
            half_power=jnp.float32(milliwatts(radio.half_power_db)),
            network_range=jnp.float32(parts["propagation"].reach(radio)),
            parts=(type(propagation), type(fading)),
        )
        if isinstance(radio, Radio):
            _try_out(made, radio)
        return made


def _try_out(radio: RadioParameters, settings: Radio) -> None:
    """Refuse a user's part that gives something else than finite float32 numbers, one for each link."""
    own = [kind for kind in ("propagation", "fading") if KINDS[kind].home(getattr(settings, kind)) is not None]
    if not own:
        return  # without what the trials below compile
    squared = jnp.geomspace(1, 1e6, _SAMPLE, dtype=jnp.float32)
    words = jax.random.bits(jax.random.key(0), (16, _SAMPLE))
    trials: dict[str, Callable[[], Any]] = {
        "propagation": lambda: radio.propagation.level(squared, jnp.zeros_like(squared)),
        "fading": lambda: radio.fading.gain(lambda k: words[k % 16]),
    }
    for kind in own:
        name = getattr(settings, kind)
        label = f"radio.{kind}={name} of {KINDS[kind].home(name)}"
        try:
            found = trials[kind]()
        except Exception as error:
            raise InputError(f"{label}: fails ({type(error).__name__}: {error}); accepted is a working part") from None
        if found is None and kind == "fading":
            continue
        if getattr(found, "shape", None) != squared.shape or getattr(found, "dtype", None) != np.float32:
            raise InputError(f"{label}: gives {type(found).__name__}; accepted is an array, float32 for every link")
        if not bool(jnp.isfinite(found).all()):
            raise InputError(f"{label}: gives NaN or infinity; accepted are finite numbers")


def received_power(
    squared_distance: jax.Array, walls: jax.Array, gain: jax.Array | None, radio: RadioParameters
) -> jax.Array:
    """Power received over each link from a sender at full power (model 3: P_t - PL(d) - walls * L_w + X).

    Args:
        squared_distance: float32 [...], m2.
        walls: float32 [...] or scalar, walls that the link crosses.
        gain: float32 [...], log2 of what fading makes of it; None for the mean.
        radio: parameters.

    Returns:
        float32 [...], mW.
    """
    level = radio.propagation.level(squared_distance, walls)
    return jnp.exp2(level if gain is None else level + gain)


def decodable(signal: jax.Array, disturbance: jax.Array, radio: RadioParameters) -> jax.Array:
    """Whether a signal is received: power >= P_rs and SINR >= threshold (model 3).

    Args:
        signal: float32 [...], mW.
        disturbance: float32 [...], mW, every other signal on the channel without the thermal noise.
        radio: parameters.

    Returns:
        bool [...].
    """
    return (signal >= radio.sensitivity) & (signal >= radio.threshold * (radio.noise + disturbance))
