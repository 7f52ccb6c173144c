"""An experiment as data: its arms, their settings in a cell, and the folder of each of its runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slcs2_jax.config import InputError, Settings, settings_from, settings_to_dict
from slcs2_jax.config.arguments import whole
from slcs2_jax.config.chosen import with_search
from slcs2_jax.config.conf import conf_dir
from slcs2_jax.config.door import check_below
from slcs2_jax.config.field import refuse
from slcs2_jax.config.schema import accepted_paths, flatten, unknown_setting
from slcs2_jax.results.arm import CELLS, arm_of, cell_of
from slcs2_jax.study.collect import POLICY


@dataclass(frozen=True)
class Arm:
    """What an arm is: settings in which it differs, or the name or path of a behaviour made by hand that it deploys."""

    settings: Mapping[str, Any]
    policy: str | None = None


@dataclass(frozen=True)
class Planned:
    """A run to be made: its settings with its folder; of a behaviour made by hand, which."""

    settings: Settings
    policy: str | None = None


@dataclass(frozen=True)
class Experiment:
    """The arms of an experiment by name. The first is the reference.

    Attributes:
        budgeted: do its searches stop by `search.episodes`? Each number of them is then a study of its own.
        apart: by how much the seeds of each cell begin after those of the cell before; 0: all cells have the same.
    """

    name: str
    title: str
    arms: Mapping[str, Arm]
    apart: int = 0
    budgeted: bool = False

    @classmethod
    def of(cls, node: Mapping[str, Any]) -> Experiment:
        """From the node `experiment` of a configuration; raises InputError."""
        arms = {}
        for name, said in node["arms"].items():
            own = dict(said)
            policy = own.pop(POLICY, None)
            arms[str(name)] = Arm(own, policy)
        return cls(
            node["name"], node["title"], arms, whole("experiment.apart", node.get("apart", 0), low=0, high=10**6)
        )

    def chosen(self, arm: str) -> list[str]:
        """The arms that arm= of the command line stands for; raises InputError."""
        if arm == "all":
            return list(self.arms)
        if arm not in self.arms:
            raise refuse("arm", arm, "one of all, " + ", ".join(self.arms))
        return [arm]


def experiments() -> dict[str, Experiment]:
    """The experiments of conf/experiment that compare arms."""
    from omegaconf import OmegaConf

    found = {}
    for file in sorted((conf_dir() / "experiment").glob("*.yaml")):
        plain: Any = OmegaConf.to_container(OmegaConf.load(file))
        if "arms" in plain["experiment"]:
            budgeted = "episodes" in plain.get("search", {})
            found[file.stem] = dataclasses.replace(Experiment.of(plain["experiment"]), budgeted=budgeted)
    return found


def reported_experiments(episodes: Sequence[int] = ()) -> dict[str, tuple[str, tuple[str, ...]]]:
    """By name: title, and the folder names of the arms, the reference first.

    Experiments whose searches stop by their episodes are there for each of these numbers of `episodes`.
    """
    found: dict[str, tuple[str, tuple[str, ...]]] = {}
    for name, one in experiments().items():
        budgets: Sequence[int | None] = episodes if one.budgeted else [None]
        for most in budgets:
            config = {} if most is None else {"search": {"episodes": most}}
            arms = tuple(arm_of(settings_with(config, arm.settings), arm.policy) for arm in one.arms.values())
            said = (name, one.title) if most is None else (f"{name}_{most}", f"{one.title}, {most} episodes")
            found[said[0]] = said[1], arms
    return found


def settings_with(config: Mapping[str, Any], own: Mapping[str, Any]) -> Settings:
    """The settings of a composed configuration with some in place of its own; `search: NAME` brings what goes with it.

    Raises InputError.
    """
    paths = accepted_paths()
    own = dict(own)
    if isinstance(own.get("search"), str):
        config = settings_to_dict(with_search(settings_from(config), own.pop("search")))
    flat = flatten(own)
    for path in flat:
        if path not in paths:
            raise unknown_setting(path)
    replaced = {paths[path] for path in flat}
    kept = {path: value for path, value in flatten(config).items() if paths.get(path) not in replaced}
    return settings_from(kept | flat)


def plan(root: str | Path, config: Mapping[str, Any], experiment: Experiment, arms: Sequence[str]) -> list[Planned]:
    """Every run of one cell: one for each arm and instance, each with its folder below `root`.

    A folder's name follows from its arm, cell and seed alone, so experiments that share runs find each other's.

    Raises:
        InputError: a bad setting, two arms that are one, or a folder on the way to a run that is a link.
    """
    found: list[Planned] = []
    names: dict[str, str] = {}
    for name in arms:
        arm = experiment.arms[name]
        settings = settings_with(config, arm.settings)
        other = names.setdefault(arm_of(settings, arm.policy), name)
        if other != name:
            raise InputError(f"arm={name}: comes to the same settings as {other}; accepted are arms that differ")
        first = settings.seed + experiment.apart * CELLS.index(cell_of(settings))
        for instance in range(settings.instances):
            one = dataclasses.replace(settings, seed=first + instance, instances=1)
            if arm.policy is not None:  # nothing evolves: however far the others go, it is the same run
                one = dataclasses.replace(one, search=dataclasses.replace(one.search, generations=1))
            folder = run_folder(root, one, arm.policy)
            check_below(Path(root), folder)
            found.append(Planned(dataclasses.replace(one, run_dir=str(folder)), arm.policy))
    return found


def run_folder(root: str | Path, settings: Settings, policy: str | None = None) -> Path:
    """ROOT/<arm>/<environment>_<range>/seed_000."""
    return Path(root) / arm_of(settings, policy) / cell_of(settings).name / f"seed_{settings.seed:03d}"
