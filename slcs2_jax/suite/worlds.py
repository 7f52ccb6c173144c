"""The frozen worlds of the suite: settings, seeds of three splits, budgets; and that they are still what they were."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

from slcs2_jax.config import InputError, Settings, settings_from
from slcs2_jax.config.errors import refuse
from slcs2_jax.config.model import ENVIRONMENTS
from slcs2_jax.config.schema import flatten
from slcs2_jax.config.yaml_text import parse_yaml
from slcs2_jax.suite.frozen import digest
from slcs2_jax.world.layout import Scenario
from slcs2_jax.world.scenario import make_scenario

SPLITS = ("train", "validation", "test")
FOLDER = "v1"


@dataclass(frozen=True, kw_only=True)
class SuiteWorld:
    """One kind of world, frozen.

    Attributes:
        version: of the suite.
        name, title: in commands, and for people.
        stated: every setting that decides, by its path.
        seeds: of each split, the first seed and how many.
        files: of each split, names of the world files that its seeds take by turns; empty where seeds make the walls.
        trainings: independent trainings of whatever is trained.
        env_steps: that one training may spend.
        sha256: checksum of the worlds of all seeds, hex; see `frozen.digest`.
    """

    version: str
    name: str
    title: str
    stated: Mapping[str, Any]
    seeds: Mapping[str, tuple[int, int]]
    files: Mapping[str, tuple[str, ...]]
    trainings: int
    env_steps: int
    sha256: str

    def seeds_of(self, split: str) -> range:
        """The seeds of a split, in order."""
        first, count = self.seeds[split]
        return range(first, first + count)

    def split_of(self, seed: int) -> str:
        """The split that a seed belongs to. Raises InputError if it is none of this world's."""
        for split in SPLITS:
            if seed in self.seeds_of(split):
                return split
        spans = ", ".join(f"{self.seeds_of(split)[0]}..{self.seeds_of(split)[-1]} ({split})" for split in SPLITS)
        raise refuse("seed", seed, f"one of {spans} in world {self.name} of {self.version}")

    def settings(self, seed: int, own: Mapping[str, Any] | None = None) -> Settings:
        """The settings of the world of a seed, and an entry's own by their paths. Raises InputError."""
        flat = {**self.stated, **(own or {}), "seed": seed, "instances": 1}
        if self.files:
            names = self.files[self.split_of(seed)]
            name = names[(seed - self.seeds_of(self.split_of(seed))[0]) % len(names)]
            flat |= {"world.file": f"{name}.yaml", "world.content": _text(f"worlds/{name}.yaml")}
        return settings_from(flat)

    def scenario(self, seed: int) -> Scenario:
        """The world of a seed."""
        return make_scenario(self.settings(seed), seed)

    @property
    def packets(self) -> int:
        """p, packets to deliver."""
        return int(self.stated["swarm.packets"])

    @property
    def time_limit(self) -> int:
        """T, time-steps."""
        return int(self.stated["world.time_limit"])

    @property
    def episodes(self) -> int:
        """Whole episodes in the budget of a training, however long they last."""
        return self.env_steps // self.time_limit

    @functools.cached_property
    def found(self) -> str:
        """The checksum of the worlds as they are made here and now."""
        every = (self.scenario(seed) for split in SPLITS for seed in self.seeds_of(split))
        return digest(self.stated, every)

    def check(self) -> None:
        """Raise InputError if these are not the worlds that the suite was published with."""
        found = self.found
        if found != self.sha256:
            raise InputError(
                f"world {self.name} of {self.version}: its checksum is {found[:16]}...; accepted is "
                f"{self.sha256[:16]}..., that of the published worlds, which these are not"
            )


@dataclass(frozen=True, kw_only=True)
class Suite:
    """All worlds of a version.

    Attributes:
        version: its name.
        deployments: of an entry in each test world.
        reference: the entry that the probability of improvement is over.
        knows: what a solution may know, in words.
        worlds: by name.
    """

    version: str
    deployments: int
    reference: str
    knows: str
    worlds: Mapping[str, SuiteWorld]

    def world(self, name: str) -> SuiteWorld:
        """A world of this name. Raises InputError with those there are."""
        if name not in self.worlds:
            raise refuse("world", name, f"one of {', '.join(self.worlds)}")
        return self.worlds[name]

    def chosen(self, said: str | None) -> list[SuiteWorld]:
        """The worlds that `world=a,b` means; all if nothing is said. Raises InputError."""
        if said is None:
            return list(self.worlds.values())
        names = dict.fromkeys(name.strip() for name in said.strip("[]").split(","))
        return [self.world(name) for name in names]


@functools.lru_cache(maxsize=1)
def load_suite() -> Suite:
    """The suite that is shipped."""
    said = parse_yaml(_text("suite.yaml"))
    physics = flatten(said["physics"])
    worlds = {}
    for name, own in said["worlds"].items():
        stated = physics | flatten(own["settings"])
        stated |= {f"world.{key}": value for key, value in ENVIRONMENTS[stated["world.environment"]].items()}
        worlds[name] = SuiteWorld(
            version=said["version"],
            name=name,
            title=own["title"],
            stated=stated,
            seeds={split: (first, count) for split, (first, count) in own["seeds"].items()},
            files={split: tuple(names) for split, names in own.get("files", {}).items()},
            trainings=own["trainings"],
            env_steps=own["env_steps"],
            sha256=own["sha256"],
        )
    general = {name: said[name] for name in ("version", "deployments", "reference", "knows")}
    return Suite(**general, worlds=worlds)


def seeds_of(world: SuiteWorld, split: str, count: int | None = None) -> Sequence[int]:
    """The first so many seeds of a split, all by default. Raises InputError for more than there are."""
    every = world.seeds_of(split)
    if count is not None and not 1 <= count <= len(every):
        raise refuse("seeds", count, f"a whole number from 1 to {len(every)}")
    return every[:count]


def _text(name: str) -> str:
    return (resources.files(__package__) / FOLDER / name).read_text(encoding="utf-8")
