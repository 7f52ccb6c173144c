"""Scenarios: one environment instance each, from type, range, seed and the world's settings (spec section 2)."""

from __future__ import annotations

import dataclasses
import enum

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.settings import Settings, World

Floats = NDArray[np.float32]

START_ATTEMPTS = 100_000


class _Stream(enum.IntEnum):
    """Each part of a scenario has a stream of its own, so that urban and urban_jammed share buildings."""

    BUILDINGS = 0
    JAMMER = 1
    STARTS = 2
    SINK = 3


@dataclasses.dataclass(frozen=True, eq=False)
class Scenario:
    """One environment instance; lengths in m.

    Attributes:
        environment: type of environment.
        seed: what it was made from, beside the settings.
        sink: float32 [2]; the source is the origin.
        sink_estimate: float32 [2], where the agents believe the sink to be.
        jammer: float32 [2], or None.
        vertical: float32 [V, 3], walls (x, lowest y, highest y) of the centre lines.
        horizontal: float32 [H, 3], walls (y, lowest x, highest x).
        wall_thickness: of every wall.
        start: float32 [n, 2], the agents' first positions.
        time_limit: T, time-steps.
    """

    environment: str
    seed: int
    sink: Floats
    sink_estimate: Floats
    jammer: Floats | None
    vertical: Floats
    horizontal: Floats
    wall_thickness: float
    start: Floats
    time_limit: int

    @property
    def walls(self) -> int:
        """Number of walls."""
        return len(self.vertical) + len(self.horizontal)


def make_scenario(settings: Settings, seed: int) -> Scenario:
    """Generate the scenario of a seed (spec section 2).

    The same settings of world, radio range and swarm size give the same scenario for every algorithm, in any batch.

    Raises:
        InputError: the walls leave no room for the agents around the source, or the seed is none.
    """
    of_kind("settings", settings, Settings)
    seed = whole("seed", seed, 0, 2**64 - 1)
    world, swarm = settings.world, settings.swarm

    def stream(purpose: _Stream) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence([seed, round(world.distance * 1000), int(purpose)]))

    sink = np.array([world.distance, 0.0])
    none = np.zeros((0, 3))
    vertical, horizontal = _buildings(world, stream(_Stream.BUILDINGS)) if world.buildings else (none, none)
    jammer = _jammer(world, settings.radio.network_range, stream(_Stream.JAMMER)) if world.jammer else None
    walls = (vertical, horizontal, world.wall_thickness / 2)
    start = _starts(swarm.agents, swarm.clearance, world.start_radius, walls, stream(_Stream.STARTS))
    estimate = sink + swarm.sink_error * stream(_Stream.SINK).standard_normal(2)
    return Scenario(
        environment=world.environment,
        seed=seed,
        sink=sink.astype(np.float32),
        sink_estimate=estimate.astype(np.float32),
        jammer=None if jammer is None else jammer.astype(np.float32),
        vertical=vertical.astype(np.float32),
        horizontal=horizontal.astype(np.float32),
        wall_thickness=world.wall_thickness,
        start=start.astype(np.float32),
        time_limit=world.time_limit,
    )


def _buildings(world: World, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Walls of 1..d/10 buildings, six candidates each: three across and three along (paper, figure of environments)."""
    most = max(1, int(world.distance / world.building_spacing))
    count = int(rng.integers(1, most + 1))
    cx = rng.uniform(0.0, world.distance, count)
    cy = rng.uniform(-world.strip_half_width, world.strip_half_width, count)
    length, width = rng.uniform(world.building_min, world.building_max, (2, count))
    present = rng.random((2, count, 3)) < world.wall_probability
    offsets = np.array([-0.5, 0.0, 0.5])
    groups = []
    for along, across, span, extent, built in (
        (cx, cy, length, width, present[0]),
        (cy, cx, width, length, present[1]),
    ):
        at = along[:, None] + offsets * span[:, None]
        low = np.broadcast_to((across - extent / 2)[:, None], at.shape)
        high = np.broadcast_to((across + extent / 2)[:, None], at.shape)
        groups.append(np.stack([at[built], low[built], high[built]], axis=1))
    half = world.wall_thickness / 2
    nodes = np.array([[0.0, 0.0], [world.distance, 0.0]])
    vertical = groups[0][~_covered(nodes, groups[0], half).any(axis=0)]
    horizontal = groups[1][~_covered(nodes[:, ::-1], groups[1], half).any(axis=0)]
    return vertical, horizontal


def _covered(points: np.ndarray, lines: np.ndarray, half: float) -> np.ndarray:
    """Whether each vertical wall covers each point: bool [points, walls]."""
    x, y = points[:, :1], points[:, 1:]
    return (np.abs(x - lines[:, 0]) <= half) & (y >= lines[:, 1]) & (y <= lines[:, 2])


def _jammer(world: World, network_range: float, rng: np.random.Generator) -> np.ndarray:
    """A place farther along than ``net`` from source and sink alike, anywhere across the strip."""
    if network_range >= world.distance / 2:
        raise InputError(
            f"world.distance={world.distance:g}: there is no place for the jammer; accepted is more than twice the "
            f"network range of {network_range:.1f} m"
        )
    along = rng.uniform(network_range, world.distance - network_range)
    return np.array([along, rng.uniform(-world.strip_half_width, world.strip_half_width)])


def _starts(
    agents: int, clearance: float, radius: float, walls: tuple[np.ndarray, np.ndarray, float], rng: np.random.Generator
) -> np.ndarray:
    """Uniform in a disc around the source, outside walls, at least one clearance apart, by rejection."""
    vertical, horizontal, half = walls
    placed = np.zeros((0, 2))
    for _ in range(START_ATTEMPTS):
        if len(placed) == agents:
            return placed
        point = rng.uniform(-radius, radius, (1, 2))
        if (point**2).sum() > radius**2 or ((placed - point) ** 2).sum(axis=1).min(initial=np.inf) < clearance**2:
            continue
        if _covered(point, vertical, half).any() or _covered(point[:, ::-1], horizontal, half).any():
            continue
        placed = np.concatenate([placed, point])
    raise InputError(
        f"swarm.agents={agents}: no place for so many at a clearance of {clearance:g} m within {radius:g} m of the "
        f"source; accepted are fewer agents, a smaller swarm.clearance or a larger world.start_radius"
    )
