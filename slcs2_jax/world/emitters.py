"""Jammers on the device where they are more than the paper's one, which stays and answers (model section 11)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.registry import KINDS
from slcs2_jax.world.emission import SILENT, Listening
from slcs2_jax.world.jammer_motion import Wandering
from slcs2_jax.world.layout import Jammer, Scenario

NOWHERE = 1.0e5  # m, where the jammer of a world without one is parked
Answer = TypeVar("Answer")


@dataclasses.dataclass(frozen=True)
class JammerRoom:
    """What a batch must have room for: jammers, points of a route, and the kinds of emission and motion that occur."""

    count: int
    points: int
    emissions: tuple[str, ...]
    motions: tuple[str, ...]


def jammer_room(scenarios: Sequence[Scenario]) -> JammerRoom | None:
    """The room that the scenarios' jammers take; None if none has more than the paper's: one that stays and answers."""
    jammers = [jammer for scenario in scenarios for jammer in scenario.jammers]
    if all(len(scenario.jammers) <= 1 for scenario in scenarios) and all(jammer.plain for jammer in jammers):
        return None
    return JammerRoom(
        count=max(len(scenario.jammers) for scenario in scenarios),
        points=max(1 + len(jammer.route) for jammer in jammers),
        emissions=tuple(sorted({jammer.emission for jammer in jammers})),
        motions=tuple(sorted({jammer.motion for jammer in jammers})),
    )


def has_room(room: JammerRoom | None, scenario: Scenario) -> bool:
    """Whether a scenario's jammers fit."""
    needed = jammer_room([scenario])
    if needed is None and room is not None:
        return len(scenario.jammers) == 0 or ({"reactive"} <= {*room.emissions} and {"fixed"} <= {*room.motions})
    if needed is None or room is None:
        return needed is None
    kinds = {*needed.emissions} <= {*room.emissions} and {*needed.motions} <= {*room.motions}
    return kinds and needed.count <= room.count and needed.points <= room.points


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Emitters:
    """All J jammers of each world; one that does not exist is silent.

    Attributes:
        exists: bool [J, ...].
        route_x, route_y: float32 [P, J, ...], m, the points of a patrol; the first is where the jammer starts.
        emission, motion: int32 [J, ...], which of `emissions` and `motions`.
        level: float32 [J, ...], power as a ratio of an agent's full power.
        speed: float32 [J, ...], m per step.
        duty: float32 [J, ...]. dwell: int32 [J, ...], steps.
        emissions, motions: names of parts; code, no arrays.
    """

    exists: jax.Array
    route_x: jax.Array
    route_y: jax.Array
    emission: jax.Array
    motion: jax.Array
    level: jax.Array
    speed: jax.Array
    duty: jax.Array
    dwell: jax.Array
    emissions: tuple[str, ...] = dataclasses.field(metadata={"static": True})
    motions: tuple[str, ...] = dataclasses.field(metadata={"static": True})


def stack_emitters(scenarios: Sequence[Scenario], room: JammerRoom) -> Emitters:
    """The jammers of scenarios, for each of which there is room, along the last axis, as NumPy arrays."""
    columns = [_column(scenario, room) for scenario in scenarios]
    fields: dict[str, Any] = {
        name: np.stack([column[name] for column in columns], axis=-1) for name in (columns[0] if columns else ())
    }
    return Emitters(**fields, emissions=room.emissions, motions=room.motions)


def _column(scenario: Scenario, room: JammerRoom) -> dict[str, np.ndarray]:
    jammers = [*scenario.jammers, *[_ABSENT] * (room.count - len(scenario.jammers))]
    routes = np.array([[j.place, *j.route, *[j.place] * (room.points - 1 - len(j.route))] for j in jammers], np.float32)
    here = np.arange(room.count) < len(scenario.jammers)

    def kinds(names: tuple[str, ...], attribute: str) -> np.ndarray:
        said = [getattr(jammer, attribute) for jammer in jammers]
        return np.array([names.index(name) if there else 0 for name, there in zip(said, here, strict=True)], np.int32)

    return {
        "exists": here,
        "route_x": routes[..., 0].T,
        "route_y": routes[..., 1].T,
        "emission": kinds(room.emissions, "emission"),
        "motion": kinds(room.motions, "motion"),
        "level": np.array([10.0 ** (jammer.power_db / 10) for jammer in jammers], np.float32),
        "speed": np.array([jammer.speed for jammer in jammers], np.float32),
        "duty": np.array([jammer.duty for jammer in jammers], np.float32),
        "dwell": np.array([jammer.dwell for jammer in jammers], np.int32),
    }


_ABSENT = Jammer(place=np.array([NOWHERE, NOWHERE], np.float32))


def transmits_on(emitters: Emitters, listening: Listening) -> jax.Array:
    """Index of the channel that each jammer transmits on: int32 [J, ...]; `SILENT` for none."""
    parts = [KINDS["emission"].get(name) for name in emitters.emissions]
    channel = _each(parts, emitters.emission, listening)
    return jnp.where(emitters.exists, channel, SILENT)


def moved(emitters: Emitters, wandering: Wandering) -> tuple[jax.Array, jax.Array]:
    """Where each jammer is after a step: float32 [J, ...] twice, m."""
    parts = [KINDS["jammer motion"].get(name) for name in emitters.motions]
    return _each(parts, emitters.motion, wandering)


def _each(parts: Sequence[Callable[[Any], Answer]], kind: jax.Array, asked: Any) -> Answer:
    """Every jammer's answer by the part that is its own."""
    answer = parts[0](asked)
    for number, part in enumerate(parts[1:], start=1):
        answer = jax.tree.map(lambda new, old, own=kind == number: jnp.where(own, new, old), part(asked), answer)
    return answer
