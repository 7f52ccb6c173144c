"""How much memory runs will take, foreseen before any is taken. n, R = agents, rules."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.field import refuse
from slcs2_jax.config.worlds import kinds_of
from slcs2_jax.native import choice
from slcs2_jax.results.rows import MOST_ROWS

MEMBERS = 50  # of a collection, as they are usually seen
_BLOCK = 4096 * 32  # bytes of the random rules that each instance holds ready
_CGROUP = Path("/sys/fs/cgroup")


def slot_bytes(settings: Settings) -> int:
    """Of one slot at its peak, when chunks are computed. Fitted to measured peaks; within a factor of two.

    The native chunk has a slot's arrays once, once more while an episode enters, and a lane group's for each thread.
    Where parts that it does not know leave a batch to XLA, it is more: up to six times for 64 agents.
    """
    n, rules, walls = settings.swarm.agents, settings.rules.rules, _walls(settings)
    if choice.expected(settings.compute):
        arrays = 37 * n * rules + 16 * n * n + 200 * n + 12 * walls
        return 8000 + round(2.3 * arrays)
    return 110 * n * rules + 30 * n * n + 270 * n + 8 * n**3 + round(walls * (60 + 0.6 * n * n))


def search_bytes(settings: Settings) -> int:
    """Of all instances' searches on the host: the members of their collections with what they learnt."""
    most = settings.search.population if settings.search.acceptance == "best" else MEMBERS
    members = 3 + min(settings.search.generations, most)
    size = 80 * settings.swarm.agents * settings.rules.rules
    return settings.instances * (_BLOCK + size * members + 40 * _walls(settings))


def measurement_bytes(settings: Settings, tasks: int, deployments: int) -> int:
    """Of so many tasks that make so many deployments in all, on the host."""
    return 16 * settings.swarm.agents * settings.rules.rules * deployments + 40 * _walls(settings) * tasks


def check_memory(settings: Settings, host_bytes: int, slots: int, devices: Sequence[Any]) -> None:
    """Raise InputError if it will not fit, naming what to lower.

    Args:
        settings: of the runs that share a batch; they have their sizes in common.
        host_bytes: that their instances take together.
        slots: over all devices.
        devices: that compute.
    """
    slots_bytes = slots * slot_bytes(settings)
    many_slots = f"compute.slots (now {slots}), swarm.agents={settings.swarm.agents} or rules.rules"
    many_instances = "the number of instances or runs, swarm.agents or rules.rules"
    if devices[0].platform == "cpu":
        most = many_slots if slots_bytes > host_bytes else many_instances
        _compare("memory", slots_bytes + host_bytes, available_host(), most)
    else:
        _compare("memory", host_bytes, available_host(), many_instances)
        _compare("device memory", slots_bytes, available_device(devices), many_slots)


def check_rows(settings: Settings) -> None:
    """Raise InputError if a run with a folder would have more rows, one for each generation, than can be read back."""
    rows = settings.search.generations * settings.instances
    if settings.run_dir is not None and rows > MOST_ROWS:
        raise refuse(
            "generations",
            settings.search.generations,
            f"at most {MOST_ROWS // settings.instances} with instances={settings.instances}: a run's folder holds up "
            f"to {MOST_ROWS:,} generations of all instances together",
        )


def check_fits(name: str, value: int, per_unit: int, what: str) -> None:
    """Raise InputError naming the setting if `per_unit` bytes for each unit of its value are not there."""
    there = available_host()
    if there is not None and value * per_unit > there:
        raise InputError(
            f"{name}={value}: {what} takes about {value * per_unit / 1e9:.1f} GB and {there / 1e9:.1f} GB are free; "
            f"accepted is at most {there // per_unit}"
        )


def _compare(what: str, needed: int, there: int | None, lower: str) -> None:
    if there is not None and needed > there:
        raise InputError(
            f"{what}: about {needed / 1e9:.1f} GB would be needed and {there / 1e9:.1f} GB are free; accepted is what "
            f"fits: lower {lower}"
        )


def available_host() -> int | None:
    """Bytes that this process may still take, None where the system does not say."""
    found = []
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text().splitlines()
        found.append(1024 * int(next(line for line in lines if line.startswith("MemAvailable")).split()[1]))
    with contextlib.suppress(OSError, ValueError):  # "max" is no number
        limit = int((_CGROUP / "memory.max").read_text())
        found.append(limit - int((_CGROUP / "memory.current").read_text()))
    return min(found, default=None)


def available_device(devices: Sequence[Any]) -> int | None:
    """Bytes left on all devices, None if they do not say."""
    total = 0
    for device in devices:
        stats = device.memory_stats() or {}
        if "bytes_limit" not in stats:
            return None
        total += stats["bytes_limit"] - stats.get("bytes_in_use", 0)
    return total


def _walls(settings: Settings) -> int:
    """The most that a scenario can have: six to a building (docs/model.md)."""
    worlds = [kind.settings(settings).world for kind in kinds_of(settings.worlds)] or [settings.world]
    return max(int(6 * world.distance / world.building_spacing) if world.buildings else 0 for world in worlds)
