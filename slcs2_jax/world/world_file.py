"""A world in a YAML file, typed as `world=PATH` on the command line, and a world written as one.

    # lengths in m, on a map with x to the right and y up
    sink: [600, 0]
    source: [0, 0]            # optional; the map is moved so that it becomes the origin
    sink_estimate: [610, 5]   # optional: where the agents believe the sink to be; else by swarm.sink_error
    time_limit: 20000         # optional, steps; else world.time_limit
    wall_thickness: 1.0       # optional: of every wall; else, and always equal to, world.wall_thickness
    walls:                    # optional; each a segment, or the four sides of a rectangle, along the axes
      - {from: [100, -20], to: [100, 20]}
      - {corner: [200, 10], opposite: [230, 35]}
    jammers:                  # optional; only the place is needed
      - {place: [300, 40], emission: reactive, motion: patrol, route: [[350, 0]], speed: 2.0, power_db: 0.0,
         duty: 0.5, dwell: 10}
    starts: [[10, 0], [0, 10]]  # optional: one for every agent; else at random around the source, as by the seed

Only what the seed and the settings still decide differs from instance to instance.
"""

from __future__ import annotations

import dataclasses
import numbers
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse, show
from slcs2_jax.config.settings import Settings
from slcs2_jax.config.yaml_text import parse_yaml
from slcs2_jax.world.layout import Jammer, Scenario
from slcs2_jax.world.scenario_check import FARTHEST, check_scenario
from slcs2_jax.world.strip import make_estimate, make_starts

_FIELDS = ("sink", "source", "sink_estimate", "time_limit", "wall_thickness", "walls", "jammers", "starts")
_JAMMER = tuple(field.name for field in dataclasses.fields(Jammer))


def scenario_from_text(settings: Settings, seed: int) -> Scenario:
    """The scenario that `world.content` describes; see the head of this file.

    Raises:
        InputError: naming the file, the field in it, and what is accepted.
    """
    world = settings.world
    try:
        scenario = _scenario(_mapping(world.content or ""), settings, seed)
        check_scenario(scenario, settings)
    except InputError as error:
        raise InputError(f"world.file={show(world.file)}: {error}") from None
    return scenario


def scenario_text(scenario: Scenario) -> str:
    """The scenario as such a file. Reading it with the same settings gives the same scenario."""

    def places(array: np.ndarray) -> Any:
        return [[float(value) for value in row] for row in array.reshape(-1, 2)]

    walls = [{"from": [at, low], "to": [at, high]} for at, low, high in scenario.vertical.tolist()]
    walls += [{"from": [low, at], "to": [high, at]} for at, low, high in scenario.horizontal.tolist()]
    jammers = []
    for jammer in scenario.jammers:
        said = {name: getattr(jammer, name) for name in _JAMMER}
        said |= {"place": places(jammer.place)[0], "route": places(jammer.route)}
        jammers.append({name: value for name, value in said.items() if name == "place" or value != _default(name)})
    lines = [
        f"# {scenario.environment}, seed {scenario.seed}; lengths in m, the source is the origin",
        f"sink: {places(scenario.sink)[0]}",
        f"sink_estimate: {places(scenario.sink_estimate)[0]}",
        f"time_limit: {int(scenario.time_limit)}",
        f"wall_thickness: {float(scenario.wall_thickness)}",
        *_list("walls", walls),
        *_list("jammers", jammers),
        *_list("starts", places(scenario.start)),
    ]
    return "\n".join(lines) + "\n"


def _list(name: str, items: Sequence[Any]) -> list[str]:
    """A list in YAML, an item a line."""
    import yaml

    said = [yaml.safe_dump(item, sort_keys=False, default_flow_style=True, width=10**6).strip() for item in items]
    return [f"{name}:", *(f"  - {item}" for item in said)] if said else [f"{name}: []"]


def _default(name: str) -> Any:
    field = next(field for field in dataclasses.fields(Jammer) if field.name == name)
    return [] if name == "route" else field.default


def _mapping(text: str) -> Mapping[str, Any]:
    """The file's content. Aliases are refused: they let a small file stand for a huge one."""
    try:
        content = parse_yaml(text)
    except InputError as error:
        raise InputError(f"{error}; accepted is a mapping of {', '.join(_FIELDS)}") from None
    return _known("the file", content, _FIELDS, ("sink",))


def _known(name: str, value: Any, fields: Sequence[str], needed: Sequence[str]) -> Mapping[str, Any]:
    """The value if it is a mapping of known fields that has those that are needed."""
    if not isinstance(value, Mapping):
        raise InputError(f"{name} is {show(value)}; accepted is a mapping of {', '.join(fields)}")
    unknown = [key for key in value if key not in fields]
    if unknown:
        raise InputError(f"{name} has {show(unknown[0])}; accepted are {', '.join(fields)}")
    for field in needed:
        if field not in value:
            raise InputError(f"{name} has no {field}; accepted is a mapping with {', '.join(needed)}")
    return value


def _scenario(content: Mapping[str, Any], settings: Settings, seed: int) -> Scenario:
    world = settings.world
    source = np.array(_place("source", content.get("source", [0.0, 0.0])))
    vertical, horizontal = _walls(_sequence("walls", content), source)
    sink = np.array(_place("sink", content["sink"])) - source
    estimate = content.get("sink_estimate")
    thickness = content.get("wall_thickness", world.wall_thickness)
    if thickness != world.wall_thickness:
        raise refuse("wall_thickness", thickness, f"{world.wall_thickness:g} m, as world.wall_thickness says")
    if "starts" in content:
        start = _array([_place(f"starts[{k}]", at) for k, at in enumerate(_sequence("starts", content))], source)
    else:
        start = make_starts(settings, seed, vertical, horizontal)
    said = None if estimate is None else _array([_place("sink_estimate", estimate)], source)[0]
    return Scenario(
        environment=Path(world.file or "file").stem,
        seed=seed,
        sink=sink.astype(np.float32),
        sink_estimate=make_estimate(settings, seed, sink) if said is None else said,
        jammers=tuple(_jammer(f"jammers[{k}]", one, source) for k, one in enumerate(_sequence("jammers", content))),
        vertical=vertical,
        horizontal=horizontal,
        wall_thickness=world.wall_thickness,
        start=start,
        time_limit=content.get("time_limit", world.time_limit),
    )


def _walls(said: Sequence[Any], source: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Walls across and along the line, as a `Scenario` has them."""
    vertical: list[tuple[float, float, float]] = []
    horizontal: list[tuple[float, float, float]] = []
    for number, one in enumerate(said):
        name = f"walls[{number}]"
        if isinstance(one, Mapping) and "corner" in one:
            wall = _known(name, one, ("corner", "opposite"), ("corner", "opposite"))
            (x1, y1), (x2, y2) = (_place(f"{name}.{end}", wall[end]) for end in ("corner", "opposite"))
            if x1 == x2 or y1 == y2:
                raise refuse(name, one, "two corners that lie across from each other")
            vertical += [(x, min(y1, y2), max(y1, y2)) for x in (x1, x2)]
            horizontal += [(y, min(x1, x2), max(x1, x2)) for y in (y1, y2)]
            continue
        wall = _known(name, one, ("from", "to"), ("from", "to"))
        (x1, y1), (x2, y2) = (_place(f"{name}.{end}", wall[end]) for end in ("from", "to"))
        if x1 == x2:
            vertical.append((x1, min(y1, y2), max(y1, y2)))
        elif y1 == y2:
            horizontal.append((y1, min(x1, x2), max(x1, x2)))
        else:
            raise refuse(name, one, "a wall along one of the axes: from and to with the same x or the same y")
    across = np.array(vertical).reshape(-1, 3) - source[[0, 1, 1]]
    along = np.array(horizontal).reshape(-1, 3) - source[[1, 0, 0]]
    return across.astype(np.float32), along.astype(np.float32)


def _jammer(name: str, said: Any, source: np.ndarray) -> Jammer:
    values = dict(_known(name, said, _JAMMER, ("place",)))
    route = _sequence("route", values, name)
    for number in ("power_db", "speed", "duty"):
        if number in values:
            values[number] = _number(f"{name}.{number}", values[number])
    values["place"] = _array([_place(f"{name}.place", values["place"])], source)[0]
    values["route"] = _array([_place(f"{name}.route[{k}]", at) for k, at in enumerate(route)], source)
    return Jammer(**values)


def _sequence(field: str, content: Mapping[str, Any], of: str = "") -> Sequence[Any]:
    value = content.get(field)
    if value is None:
        return ()
    if not isinstance(value, list):
        raise refuse(f"{of}.{field}" if of else field, value, "a list")
    return value


def _place(name: str, value: Any) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise refuse(name, value, "a place, [x, y] in m")
    x, y = (_number(name, one) for one in value)
    return x, y


def _number(name: str, value: Any) -> float:
    number = isinstance(value, numbers.Real) and not isinstance(value, bool)
    if not number or not abs(value) <= FARTHEST:  # so that NaN fails
        raise refuse(name, value, f"a finite number up to {FARTHEST:g}")
    return float(value)


def _array(places: Sequence[tuple[float, float]], source: np.ndarray) -> np.ndarray:
    """float32 [places, 2], from the source."""
    return (np.array(places).reshape(-1, 2) - source).astype(np.float32)
