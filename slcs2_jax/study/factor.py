"""Factors: the settings in which runs that are compared differ, beside their world and their algorithm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from slcs2_jax.config import Settings, World
from slcs2_jax.config.field import Described, show
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.results.arm import ALGORITHM, WORLD, Cell, cell_of

# How far a run goes, which the report treats by itself; and of the settings that are no part of the model the one that
# figures depend on.
_GENERATIONS, _FRESH = "generations", "search.fresh_deployments"
# What the world's type and range set: these differ between worlds, and are a factor only if they differ within one.
_OF_THE_WORLD = ("world.buildings", "world.jammer", "world.distance", "world.time_limit")

Point = tuple[tuple[str, Any], ...]


@dataclass(frozen=True, eq=False)
class Factor:
    """A setting with more than one value.

    Attributes:
        name, unit, help: of the setting, as a user types and reads it.
        values: all that occur; numbers from the least on.
        default: the setting's own.
        base: by world, the value from which single changes are told; the same in all worlds, unless the world's type
            or range set it.
    """

    name: str
    unit: str
    help: str
    values: tuple[Any, ...]
    default: Any
    base: Mapping[Cell, Any]

    @property
    def numeric(self) -> bool:
        """Do all values stand on a number line?"""
        return all(isinstance(value, int | float) and not isinstance(value, bool) for value in self.values)

    @property
    def label(self) -> str:
        """For an axis: swarm.speed (m)."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


def factors(runs: Iterable[Settings]) -> tuple[Factor, ...]:
    """The factors of some runs, in the order in which settings are listed."""
    every = list(runs)
    fields = [(section, field) for section, field in settings_fields() if _counts(field)]
    varied = [(section, field) for section, field in fields if _varies(every, section, field)]
    general = [pair for pair in varied if pair[1].name not in _OF_THE_WORLD]
    at_base = dict(zip((field.name for _, field in general), _usual(every, general), strict=True))
    cells = {cell_of(one) for one in every}
    found = []
    for section, field in varied:
        values = _in_order({_value(one, section, field) for one in every})
        if field.name in at_base:
            base = dict.fromkeys(cells, at_base[field.name])
        else:
            base = {cell: _base_within(cell, every, section, field) for cell in cells}
        found.append(Factor(field.name, field.doc.unit, field.doc.help, values, field.default, base))
    return tuple(found)


def point_of(settings: Settings, among: Sequence[Factor]) -> Point:
    """The factors in which a run is not at the base of its world, with its values."""
    cell, own = cell_of(settings), values_of(settings, among)
    return tuple((one.name, own[one.name]) for one in among if own[one.name] != one.base[cell])


def values_of(settings: Settings, among: Sequence[Factor]) -> dict[str, Any]:
    """A run's value of each factor."""
    names = {one.name for one in among}
    return {field.name: _value(settings, section, field) for section, field in settings_fields() if field.name in names}


def shared_changes(runs: Sequence[Settings]) -> list[tuple[str, Any, Any]]:
    """Settings that all runs have alike and not at their default, or that of their world: name, value, default."""
    found = []
    for section, field in settings_fields():
        if not _counts(field):
            continue
        defaults = {field.default}
        if field.name in _OF_THE_WORLD:
            defaults = {getattr(World.preset(*cell_of(one)), field.attribute) for one in runs}
        values = {_value(one, section, field) for one in runs}
        if len(values) == 1 and not values & defaults:
            found.append((field.name, values.pop(), _in_order(defaults)[0]))
    return found


def point_text(point: Point) -> str:
    """As a user types it: swarm.speed=4, radio.noise_dbm=-90.0."""
    return ", ".join(f"{name}={show(value)}" for name, value in point)


def _counts(field: Described) -> bool:
    no_matter = field.doc.status == "run" and field.name != _FRESH
    return not no_matter and field.name not in (_GENERATIONS, *ALGORITHM, *WORLD)


def _value(settings: Settings, section: str, field: Described) -> Any:
    return getattr(getattr(settings, section) if section else settings, field.attribute)


def _varies(runs: Sequence[Settings], section: str, field: Described) -> bool:
    """Within a world, of what a world's type and range set."""
    groups: dict[Cell | None, set[Any]] = {}
    for one in runs:
        group = cell_of(one) if field.name in _OF_THE_WORLD else None
        groups.setdefault(group, set()).add(_value(one, section, field))
    return any(len(values) > 1 for values in groups.values())


def _usual(runs: Sequence[Settings], among: Sequence[tuple[str, Described]]) -> tuple[Any, ...]:
    """Of the combinations that occur, the one with the most defaults; of these the commonest, then the least."""
    found = Counter(tuple(_value(one, section, field) for section, field in among) for one in runs)

    def rank(combination: tuple[Any, ...]) -> tuple[int, int, list[Any]]:
        defaults = sum(value == field.default for value, (_, field) in zip(combination, among, strict=True))
        return -defaults, -found[combination], [_sort_key(value) for value in combination]

    return min(found, key=rank)


def _base_within(cell: Cell, runs: Sequence[Settings], section: str, field: Described) -> Any:
    """What the world's type and range set, if a run in this world has it; else the least that occurs there."""
    values = {_value(one, section, field) for one in runs if cell_of(one) == cell}
    preset = getattr(World.preset(*cell), field.attribute)
    return preset if preset in values else _in_order(values)[0]


def _in_order(values: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(sorted(values, key=_sort_key))


def _sort_key(value: Any) -> tuple[bool, float, str]:
    number = isinstance(value, int | float)
    return not number, float(value) if number else 0.0, str(value)
