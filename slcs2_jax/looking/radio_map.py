"""What the radio reaches: mean power, or mean SINR, of the strongest sender at every place of the map (model 3).

The fading, whatever it is, is left out: of the log-normal shadowing the mean in dB is so shown, of any other fading the
mean power. Senders are the source and the agents that work, at full power. A reactive jammer is taken to emit, as it
does while it hears anybody; another counts if it emits on the first channel in use in the step.
"""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from slcs2_jax.looking.recording import Recording
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.geometry import Walls, count_crossings
from slcs2_jax.world.radio import RadioParameters, received_power

FIELDS = ("power", "sinr")
MOST_PLACES = 6000  # of a map

Floats = NDArray[np.float64]
Place = tuple[float, float]


def field(recording: Recording, name: str, moment: int, within: tuple[float, float, float, float]) -> Floats:
    """A map at a moment: float64 [rows from the bottom, columns]; dBm of `power`, dB of `sinr`.

    Args:
        recording: whose agents, and where.
        name: one of FIELDS.
        moment: when.
        within: left, right, bottom and top of the map, m.
    """
    x, y = grid(within)
    working = [*np.flatnonzero(~recording.down[moment]).tolist(), recording.source]
    nodes = [recording.place(moment, node) for node in working]
    power = received(recording, nodes, x, y).max(axis=0)
    if name == "power":
        return 10 * np.log10(power)
    disturbance = np.full(x.shape, 10 ** (recording.settings.radio.noise_dbm / 10))
    for jammer, place in enumerate(recording.jammer_places(moment)):
        if recording.emits(jammer, moment):
            level = 10 ** (recording.scenario.jammers[jammer].power_db / 10)
            disturbance += level * received(recording, [place], x, y)[0]
    return 10 * np.log10(power / disturbance)


def grid(within: tuple[float, float, float, float]) -> tuple[Floats, Floats]:
    """Places of a map, the middles of equal squares: x and y, float64 [rows, columns], m."""
    left, right, bottom, top = within
    side = np.sqrt((right - left) * (top - bottom) / MOST_PLACES)
    columns, rows = (max(1, int(length / side)) for length in (right - left, top - bottom))
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    return tuple(np.meshgrid(x, y))  # type: ignore[return-value]


def received(recording: Recording, senders: Sequence[Place], x: Floats, y: Floats) -> Floats:
    """Mean power received from each of some senders at full power: mW, float64 [senders, *shape of x]."""
    one = recording.scenario
    arena = stack([one], [recording.channels], capacity=wall_capacity([one]), width=max(recording.channels) + 1)
    power = _received(
        jnp.asarray(np.array(senders, np.float32)),
        jnp.asarray(x.ravel().astype(np.float32)),
        jnp.asarray(y.ravel().astype(np.float32)),
        arena.walls,
        RadioParameters.of(recording.settings.radio),
    )
    return np.asarray(power, np.float64).reshape(-1, *x.shape)


@jax.jit
def _received(senders: jax.Array, x: jax.Array, y: jax.Array, walls: Walls, radio: RadioParameters) -> jax.Array:
    """The simulator's own formulas: float32 [K, 2], [N], [N] -> [K, N]."""
    x1, x2 = jnp.broadcast_arrays(senders[:, :1], x)
    y1, y2 = jnp.broadcast_arrays(senders[:, 1:], y)
    crossed = count_crossings(x1, y1, x2, y2, walls)
    return received_power((x2 - x1) ** 2 + (y2 - y1) ** 2, crossed, None, radio)
