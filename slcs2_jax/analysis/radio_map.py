"""What the radio reaches: mean power, or mean SINR, of the strongest sender at every place of the map (spec section 3).

The mean is over the shadowing, in dB: the shadowing, which has mean 0, is left out. Senders are the source and the
agents, at full power; a jammer is taken to emit, as it does while it hears anybody.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.settings import Radio
from slcs2_jax.recording import Recording
from slcs2_jax.world.scenario import Scenario

FIELDS = ("power", "sinr")
MOST_PLACES = 6000  # of a map

Floats = NDArray[np.float64]


def field(recording: Recording, name: str, moment: int, within: tuple[float, float, float, float]) -> Floats:
    """A map at a moment: float64 [rows from the bottom, columns]; dBm of `power`, dB of `sinr`.

    Args:
        recording: whose agents, and where.
        name: one of FIELDS.
        moment: when.
        within: left, right, bottom and top of the map, m.
    """
    x, y = grid(within)
    radio, scenario = recording.settings.radio, recording.scenario
    nodes = [recording.place(moment, node) for node in range(recording.agents + 1)]
    power = np.max([received_dbm(radio, scenario, place, x, y) for place in nodes], axis=0)
    if name == "power":
        return power
    noise = _milliwatts(radio.noise_dbm)
    if scenario.jammer is not None:
        place = float(scenario.jammer[0]), float(scenario.jammer[1])
        noise = noise + _milliwatts(received_dbm(radio, scenario, place, x, y))
    return power - 10 * np.log10(noise)


def grid(within: tuple[float, float, float, float]) -> tuple[Floats, Floats]:
    """Places of a map, the middles of equal squares: x and y, float64 [rows, columns], m."""
    left, right, bottom, top = within
    side = np.sqrt((right - left) * (top - bottom) / MOST_PLACES)
    columns, rows = (max(1, int(length / side)) for length in (right - left, top - bottom))
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    return tuple(np.meshgrid(x, y))  # type: ignore[return-value]


def received_dbm(radio: Radio, scenario: Scenario, sender: tuple[float, float], x: Floats, y: Floats) -> Floats:
    """Mean power received from a sender at full power, dBm: P_t - PL(d) - walls * L_w."""
    metres = np.maximum(np.hypot(x - sender[0], y - sender[1]), radio.reference_distance)
    loss = radio.reference_loss_db + 10 * radio.path_loss_exponent * np.log10(metres / radio.reference_distance)
    return radio.power_dbm - loss - radio.wall_loss_db * walls_between(scenario, sender, x, y)


def walls_between(scenario: Scenario, sender: tuple[float, float], x: Floats, y: Floats) -> NDArray[np.int64]:
    """How many walls stand between a sender and each place: int64, the shape of `x`."""
    upright = _crossed(sender[0], sender[1], x, y, scenario.vertical)
    return upright + _crossed(sender[1], sender[0], y, x, scenario.horizontal)


def _crossed(x1: float, y1: float, x2: Floats, y2: Floats, lines: NDArray[np.float32]) -> NDArray[np.int64]:
    """Crossings with vertical walls (at, low, high); with horizontal ones if x and y are exchanged."""
    count = np.zeros(x2.shape, np.int64)
    run = x2 - x1
    slope = np.divide(y2 - y1, run, out=np.zeros_like(run), where=run != 0)
    for at, low, high in lines.tolist():
        height = y1 + (at - x1) * slope
        count += ((x1 < at) != (x2 < at)) & (height >= low) & (height <= high)
    return count


def _milliwatts(dbm: Floats | float) -> Floats:
    return np.asarray(10 ** (np.asarray(dbm, np.float64) / 10))
