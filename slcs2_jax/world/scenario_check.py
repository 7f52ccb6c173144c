"""Whether a scenario is one that the model can compute: said in one line, naming the field, before anything starts."""

from __future__ import annotations

import dataclasses
import numbers
from typing import Any

import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import accepted, check, described, refuse, show
from slcs2_jax.config.jammers import MOST_JAMMERS, MOST_POINTS, Jammers
from slcs2_jax.config.settings import Settings
from slcs2_jax.world.layout import Jammer, Scenario

FARTHEST = 1.0e5  # m from the source: beyond, float32 tells no steps apart
MOST_WALLS = 20_000  # of each direction
MOST_STEPS = 10**7


def check_scenario(scenario: Scenario, settings: Settings) -> None:
    """Refuse a scenario that these settings cannot compute.

    Looked at are types, shapes and finite numbers of every field, that nothing is farther than `FARTHEST` from the
    source, that walls' ends are in order and their thickness is that of the settings, that there is a start for every
    agent and no two agents start at one place, and that every jammer names an emission and a motion that exist.

    Raises:
        InputError: one line that names the field and what is accepted.
    """
    _text("environment", scenario.environment)
    _whole("seed", scenario.seed, 0, 2**64 - 1)
    _whole("time_limit", scenario.time_limit, 1, MOST_STEPS)
    _places("sink", scenario.sink, (2,))
    _places("sink_estimate", scenario.sink_estimate, (2,))
    _places("start", scenario.start, (settings.swarm.agents, 2))
    for side in ("vertical", "horizontal"):
        _walls(side, getattr(scenario, side))
    thickness = scenario.wall_thickness
    if not _is_number(thickness) or thickness != settings.world.wall_thickness:
        raise _wrong("wall_thickness", thickness, f"{settings.world.wall_thickness:g} m, as world.wall_thickness says")
    if not np.any(scenario.sink):
        raise _wrong("sink", scenario.sink, "a place other than the source, which is the origin")
    if len(np.unique(scenario.start, axis=0)) < len(scenario.start):
        raise _wrong("start", scenario.start, "a place of its own for every agent")
    if not isinstance(scenario.jammers, tuple) or not all(isinstance(one, Jammer) for one in scenario.jammers):
        raise _wrong("jammers", scenario.jammers, "a tuple of Jammer")
    if len(scenario.jammers) > MOST_JAMMERS:
        raise _wrong("jammers", len(scenario.jammers), f"at most {MOST_JAMMERS}")
    for number, jammer in enumerate(scenario.jammers):
        _jammer(f"jammers[{number}]", jammer)


def _jammer(name: str, jammer: Jammer) -> None:
    _places(f"{name}.place", jammer.place, (2,))
    _places(f"{name}.route", jammer.route, (None, 2))
    if len(jammer.route) >= MOST_POINTS:
        raise _wrong(f"{name}.route", len(jammer.route), f"at most {MOST_POINTS - 1} points")
    for field in described(Jammers):
        if field.attribute in {one.name for one in dataclasses.fields(Jammer)}:
            try:
                check(field, getattr(jammer, field.attribute))
            except InputError:
                raise _wrong(f"{name}.{field.attribute}", getattr(jammer, field.attribute), accepted(field)) from None


def _walls(name: str, walls: Any) -> None:
    _places(name, walls, (None, 3))
    if len(walls) > MOST_WALLS:
        raise _wrong(name, f"{len(walls)} walls", f"at most {MOST_WALLS}")
    wrong = np.flatnonzero(walls[:, 1] > walls[:, 2])
    if len(wrong):
        raise _wrong(f"{name}[{wrong[0]}]", walls[wrong[0]], "(line, low, high) with low <= high")


def _places(name: str, value: Any, shape: tuple[int | None, ...]) -> None:
    wanted = "[" + ", ".join("any" if size is None else str(size) for size in shape) + "]"
    accepts = f"a float32 array {wanted} of finite m up to {FARTHEST:g} from the source"
    if not isinstance(value, np.ndarray):
        raise _wrong(name, type(value).__name__, accepts)
    fits = value.ndim == len(shape) and all(size in (None, of) for size, of in zip(shape, value.shape, strict=True))
    if value.dtype != np.float32 or not fits:
        raise _wrong(name, f"{value.dtype} {list(value.shape)}", accepts)
    if not np.isfinite(value).all() or (np.abs(value) > FARTHEST).any():
        bad = value[~np.isfinite(value) | (np.abs(value) > FARTHEST)]
        raise _wrong(name, float(bad[0]), accepts)


def _whole(name: str, value: Any, low: int, high: int) -> None:
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool | np.bool_)
    if not whole or not low <= int(value) <= high:
        raise _wrong(name, value, f"a whole number from {low} to {high}")


def _text(name: str, value: Any) -> None:
    if not isinstance(value, str):
        raise _wrong(name, value, "a text")


def _is_number(value: Any) -> bool:
    return isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)


def _wrong(field: str, value: Any, accepts: str) -> InputError:
    return refuse(f"scenario.{field}", show(value if not isinstance(value, np.ndarray) else value.tolist()), accepts)
