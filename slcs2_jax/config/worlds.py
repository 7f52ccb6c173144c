"""Many worlds for one search: `worlds=[open/short/0..7, jammed/short/0..7]`.

An entry is an environment, a range and seeds, or an environment and seeds: then distance and time limit stay what the
settings have. All else (radio, swarm, jammers, buildings) is the run's. The worlds are taken by turns, one of each
entry, so that every kind comes early and often.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.model import ENVIRONMENTS, RANGES

if TYPE_CHECKING:
    from slcs2_jax.config.settings import Settings

MOST_WORLDS = 1000
_ENTRY = re.compile(r"([a-z_]+)/(?:([a-z_]+)/)?([0-9]{1,10})(?:\.\.([0-9]{1,10}))?")
_LARGEST = 2**31 - 1  # seed
ACCEPTED = (
    "a list of ENVIRONMENT/RANGE/SEEDS, [open/short/0..7, urban/short/12]; swarm, radio and jammers are the run's own"
)


@dataclass(frozen=True)
class Kind:
    """An entry of a list of worlds; range None: as the settings have it."""

    environment: str
    range: str | None
    seeds: tuple[int, ...]

    @property
    def name(self) -> str:
        """open/short, or open."""
        return self.environment if self.range is None else f"{self.environment}/{self.range}"

    def settings(self, settings: Settings) -> Settings:
        """Of one world of this kind, but for its seed."""
        where = ENVIRONMENTS[self.environment] | ({} if self.range is None else RANGES[self.range])
        return replace(settings, worlds=(), world=replace(settings.world, **where))


def kinds_of(entries: Sequence[str]) -> tuple[Kind, ...]:
    """What a list of worlds says. Raises InputError for an entry that is none, a world twice, and too many worlds."""
    found = tuple(_kind(entry) for entry in entries)
    count = sum(len(one.seeds) for one in found)
    if count > MOST_WORLDS:
        raise InputError(f"worlds: {count} worlds; accepted are at most {MOST_WORLDS}")
    seen: set[tuple[str, str | None, int]] = set()
    for one in found:
        for seed in one.seeds:
            world = one.environment, one.range, seed
            if world in seen:
                raise InputError(f"worlds: {one.name}/{seed} is there twice; accepted is each world once")
            seen.add(world)
    return found


def _kind(entry: str) -> Kind:
    match = _ENTRY.fullmatch(entry)
    if match is None:
        raise refuse("worlds", entry, ACCEPTED)
    environment, distance, first, last = match.groups()
    if environment not in ENVIRONMENTS:
        raise refuse("worlds", entry, "environments " + ", ".join(ENVIRONMENTS))
    if distance is not None and distance not in RANGES:
        raise refuse("worlds", entry, "ranges " + ", ".join(RANGES))
    start, end = int(first), int(first if last is None else last)
    if not start <= end <= _LARGEST:
        raise refuse("worlds", entry, f"seeds from a smaller to a greater one, at most {_LARGEST}")
    if end - start >= MOST_WORLDS:
        raise InputError(f"worlds: {end - start + 1} worlds; accepted are at most {MOST_WORLDS}")
    return Kind(environment, distance, tuple(range(start, end + 1)))


def worlds_of(settings: Settings) -> list[tuple[Kind, Settings, int]]:
    """Kind, settings and seed of every world, by turns; [] for a run that has one world for each instance."""
    kinds = [(kind, kind.settings(settings)) for kind in kinds_of(settings.worlds)]
    turns = itertools.zip_longest(*([(kind, its, seed) for seed in kind.seeds] for kind, its in kinds))
    return [one for turn in turns for one in turn if one is not None]


def home_of(settings: Settings, seed: int, deployment: int) -> tuple[Settings, int]:
    """Settings and seed of the world in which a deployment of an instance takes place."""
    found = worlds_of(settings)
    if not found:
        return settings, seed
    _, its, own = found[deployment % len(found)]
    return its, own
