"""Scenarios on the device: many of them stacked, the batch axis last."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from slcs2_jax.world.emitters import NOWHERE, Emitters, JammerRoom, jammer_room, stack_emitters
from slcs2_jax.world.geometry import BLOCK, Lines, Walls
from slcs2_jax.world.scenario import Scenario

PADDING = (1.0e30, 1.0, -1.0)  # a wall that nothing meets, its squared distance infinite: low > high


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Arena:
    """What does not change during an episode. The source is the origin.

    Attributes:
        sink_x, sink_y: float32 [...], m.
        estimate_x, estimate_y: float32 [...], m, where the agents believe the sink to be.
        jammer_x, jammer_y: float32 [...], m, where the first jammer starts.
        has_jammer: bool [...].
        walls: vertical and horizontal, [V, ...] and [H, ...].
        start_x, start_y: float32 [n, ...], m.
        time_limit: int32 [...], T.
        channels: bool [C, ...], the channels that the instance's grammar uses.
        emitters: all jammers, the first among them; None if no world has more than one that stays and answers.
    """

    sink_x: jax.Array
    sink_y: jax.Array
    estimate_x: jax.Array
    estimate_y: jax.Array
    jammer_x: jax.Array
    jammer_y: jax.Array
    has_jammer: jax.Array
    walls: Walls
    start_x: jax.Array
    start_y: jax.Array
    time_limit: jax.Array
    channels: jax.Array
    emitters: Emitters | None = None


def wall_capacity(scenarios: Sequence[Scenario]) -> tuple[int, int]:
    """Rows needed for the vertical and horizontal walls of any of the scenarios, in whole blocks."""
    most = [max((len(getattr(s, side)) for s in scenarios), default=0) for side in ("vertical", "horizontal")]
    vertical, horizontal = (-(-count // BLOCK) * BLOCK for count in most)
    return vertical, horizontal


def stack(
    scenarios: Sequence[Scenario],
    channels: Sequence[Sequence[int]],
    *,
    capacity: tuple[int, int],
    width: int,
    jammers: JammerRoom | None = None,
) -> Arena:
    """Stack scenarios along the last axis, as NumPy arrays ready for the device.

    Args:
        scenarios: B scenarios with the same number of agents.
        channels: for each, the indices of the channels that its grammar uses.
        capacity: rows for vertical and horizontal walls.
        width: number of channels simulated, C.
        jammers: room for these; None takes what the scenarios ask for.
    """
    room = jammers or jammer_room(scenarios)
    vertical = _padded([s.vertical for s in scenarios], capacity[0])
    horizontal = _padded([s.horizontal for s in scenarios], capacity[1])
    nowhere = np.array([NOWHERE, NOWHERE])
    first = np.array([nowhere if s.jammer is None else s.jammer for s in scenarios], np.float32)
    sinks, estimates = (np.array([getattr(s, name) for s in scenarios]) for name in ("sink", "sink_estimate"))
    starts = np.stack([s.start for s in scenarios], axis=-1)
    fields: dict[str, Any] = dict(  # NumPy arrays, until they are put on a device
        sink_x=sinks[:, 0],
        sink_y=sinks[:, 1],
        estimate_x=estimates[:, 0],
        estimate_y=estimates[:, 1],
        jammer_x=first[:, 0],
        jammer_y=first[:, 1],
        has_jammer=np.array([s.jammer is not None for s in scenarios]),
        walls=Walls(vertical, horizontal),
        start_x=starts[:, 0],
        start_y=starts[:, 1],
        time_limit=np.array([s.time_limit for s in scenarios], np.int32),
        channels=np.array([[c in used for used in channels] for c in range(width)]),
        emitters=None if room is None else stack_emitters(scenarios, room),
    )
    return Arena(**fields)


def _padded(walls: Sequence[np.ndarray], capacity: int) -> Lines:
    rows = np.empty((3, capacity, len(walls)), np.float32)
    rows[:] = np.array(PADDING, np.float32)[:, None, None]
    for b, lines in enumerate(walls):
        rows[:, : len(lines), b] = lines.T
    return Lines(*rows)
