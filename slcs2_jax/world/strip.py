"""The paper's worlds: a strip from source to sink, with buildings, jammers and agents at random (model section 2)."""

from __future__ import annotations

import enum
import math

import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.model import World
from slcs2_jax.config.radio import log_distance_reach
from slcs2_jax.config.settings import Settings
from slcs2_jax.world.layout import Jammer, Scenario

START_ATTEMPTS = 100_000


class _Stream(enum.IntEnum):
    """Each part of a scenario has a stream of its own, so that urban and urban_jammed share buildings."""

    BUILDINGS = 0
    JAMMER = 1
    STARTS = 2
    SINK = 3
    ROUTES = 4


def make_strip(settings: Settings, seed: int) -> Scenario:
    """Generate the scenario of a seed (model section 2).

    Raises:
        InputError: there is no place for the jammers, or the walls leave no room for the agents around the source.
    """
    world = settings.world
    sink = np.array([world.distance, 0.0])
    vertical = horizontal = np.zeros((0, 3))
    if world.buildings:
        vertical, horizontal = _buildings(world, stream(settings, seed, _Stream.BUILDINGS))
    start = make_starts(settings, seed, vertical, horizontal)
    return Scenario(
        environment=world.environment,
        seed=seed,
        sink=sink.astype(np.float32),
        sink_estimate=make_estimate(settings, seed, sink),
        jammers=_jammers(settings, seed) if world.jammer else (),
        vertical=vertical.astype(np.float32),
        horizontal=horizontal.astype(np.float32),
        wall_thickness=world.wall_thickness,
        start=start,
        time_limit=world.time_limit,
    )


def make_starts(settings: Settings, seed: int, vertical: np.ndarray, horizontal: np.ndarray) -> np.ndarray:
    """The agents' first places at random around the source, clear of the walls: float32 [n, 2], m."""
    world, swarm = settings.world, settings.swarm
    walls = (vertical, horizontal, world.wall_thickness / 2)
    rng = stream(settings, seed, _Stream.STARTS)
    return _starts(swarm.agents, swarm.clearance, world.start_radius, walls, rng).astype(np.float32)


def make_estimate(settings: Settings, seed: int, sink: np.ndarray) -> np.ndarray:
    """Where the agents believe the sink to be: float32 [2], m."""
    error = settings.swarm.sink_error * stream(settings, seed, _Stream.SINK).standard_normal(2)
    return (sink + error).astype(np.float32)


def stream(settings: Settings, seed: int, purpose: _Stream) -> np.random.Generator:
    """The random numbers of one part of a scenario."""
    entropy = [seed, round(settings.world.distance * 1000), int(purpose)]
    return np.random.default_rng(np.random.SeedSequence(entropy))


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


def _jammers(settings: Settings, seed: int) -> tuple[Jammer, ...]:
    """All jammers, each at a place of its own; of a patrol its further points, too."""
    said = settings.jammers
    rng, routes = stream(settings, seed, _Stream.JAMMER), stream(settings, seed, _Stream.ROUTES)
    points = said.patrol_points - 1 if said.motion == "patrol" else 0
    return tuple(
        Jammer(
            place=_place(settings, rng).astype(np.float32),
            emission=said.emission,
            motion=said.motion,
            power_db=said.power_db,
            speed=said.speed,
            duty=said.duty,
            dwell=said.dwell,
            route=np.array([_place(settings, routes) for _ in range(points)], np.float32).reshape(-1, 2),
        )
        for _ in range(said.count)
    )


def _place(settings: Settings, rng: np.random.Generator) -> np.ndarray:
    """A place farther along than ``net`` from source and sink alike, anywhere across the strip; or a quiet one."""
    world, net = settings.world, settings.radio.network_range
    if settings.jammers.margin_db is not None:
        return _quiet_place(settings, rng)
    if net >= world.distance / 2:
        raise InputError(
            f"world.distance={world.distance:g}: there is no place for the jammer; accepted is more than twice the "
            f"network range of {net:.1f} m"
        )
    along = rng.uniform(net, world.distance - net)
    return np.array([along, rng.uniform(-world.strip_half_width, world.strip_half_width)])


def _quiet_place(settings: Settings, rng: np.random.Generator) -> np.ndarray:
    """A place in the strip from which the mean power at source and sink is the margin below the noise, or less."""
    world, radio, jammers = settings.world, settings.radio, settings.jammers
    margin = jammers.margin_db or 0.0
    if radio.propagation != "log_distance":
        raise InputError(
            f"jammers.margin_db={margin:g}: it is worked out for radio.propagation=log_distance; accepted is null with "
            f"{radio.propagation}"
        )
    level = min(radio.noise_dbm, radio.receive_threshold_dbm) - margin
    least = log_distance_reach(radio, radio.power_dbm + jammers.power_db, level)
    half = world.strip_half_width
    if math.hypot(world.distance / 2, half) > least:
        for _ in range(START_ATTEMPTS):
            place = np.array([rng.uniform(0, world.distance), rng.uniform(-half, half)])
            if min(math.hypot(*place), math.hypot(place[0] - world.distance, place[1])) >= least:
                return place
    raise InputError(
        f"jammers.margin_db={margin:g}: no place for the jammer, which would have to be {least:.4g} m from source and "
        f"sink; accepted is a lower jammers.power_db, a longer world.distance or a wider world.strip_half_width"
    )


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
