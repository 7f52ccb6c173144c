"""The algorithms by name, with settings by name, for configurations and commands; and the policies that they kept."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jax

from slcs2_jax.config.arguments import of_kind, path_of, whole
from slcs2_jax.config.errors import InputError, refuse, show
from slcs2_jax.config.field import described
from slcs2_jax.learning import evolution_strategy, ippo
from slcs2_jax.learning.ippo_settings import Ippo
from slcs2_jax.learning.network_settings import NetworkSettings
from slcs2_jax.learning.strategy_settings import Strategy
from slcs2_jax.learning.training_folder import MOST_COUNTED, POLICY
from slcs2_jax.learning.worlds import Worlds
from slcs2_jax.policy.bound import BoundPolicy, load_bound
from slcs2_jax.results import Report
from slcs2_jax.results.files import names_in

ALGORITHMS: dict[str, tuple[type[Any], Callable[..., BoundPolicy]]] = {
    "ippo": (Ippo, ippo.train),
    "strategy": (Strategy, evolution_strategy.train),
}
_KEPT = re.compile(r"policy(_\d{12})?\.npz")
_MOST_BEYOND = 2**29  # bytes


def train(
    algorithm: str,
    changes: Mapping[str, Any],
    worlds: Worlds,
    *,
    seed: int,
    budget_env_steps: int,
    folder: str | Path | None = None,
    report: Report | None = None,
) -> BoundPolicy:
    """Train a network by an algorithm's name; see `ippo.train` and `evolution_strategy.train`.

    changes: settings in place of the defaults, see `settings_of`.
    """
    settings = settings_of(algorithm, changes)
    made = ALGORITHMS[algorithm][1]
    return made(settings, worlds, seed=seed, budget_env_steps=budget_env_steps, folder=folder, report=report)


def settings_of(algorithm: str, changes: Mapping[str, Any]) -> Any:
    """Settings by their names: `settings_of("ippo", {"ippo.episodes": 64, "network.recurrent": 32})`.

    Raises InputError for a name that is none, or a value that is not accepted.
    """
    if algorithm not in ALGORITHMS:
        raise refuse("algorithm", algorithm, f"one of {', '.join(ALGORITHMS)}")
    kind = ALGORITHMS[algorithm][0]
    usual = kind()
    sections: dict[str, dict[str, Any]] = {kind.SECTION: {}, NetworkSettings.SECTION: {}}
    known = {field.name: field for section in (kind, NetworkSettings) for field in described(section)}
    for name, value in of_kind("changes", changes, dict).items():
        if name not in known:
            raise InputError(f"{show(name)}: no such setting; accepted are {', '.join(known)}")
        sections[name.partition(".")[0]][known[name].attribute] = value
    network = {field.attribute: getattr(usual.network, field.attribute) for field in described(NetworkSettings)}
    return kind(network=NetworkSettings(**network | sections[NetworkSettings.SECTION]), **sections[kind.SECTION])


def kept(folder: str | Path) -> list[tuple[int, BoundPolicy]]:
    """The policies in a training's folder, with the env-steps after which each was kept, in order.

    Raises InputError naming a file that is damaged, or the folder if all of them take too much memory.
    """
    place = path_of("folder", folder)
    found, size = [], 0  # bytes in memory, beyond what files of weights, which do not compress, take
    for name in names_in(place, inside=place):
        if _KEPT.fullmatch(name):
            policy, about = load_bound(place / name)
            size += sum(leaf.nbytes for leaf in jax.tree.leaves(policy.given)) - 8 * os.stat(place / name).st_size
            if size > _MOST_BEYOND:
                raise InputError(
                    f"folder={place}: its policies take gigabytes, their files do not; accepted are weights"
                )
            found.append((count_in(about, "env_steps", place / name), name == POLICY, policy))
    return [(steps, policy) for steps, _, policy in sorted(found, key=lambda one: one[:2])]


def count_in(about: Mapping[str, Any], name: str, file: Path) -> int:
    """A count in the remarks of a policy's file. Raises InputError naming the file if it is none."""
    try:
        return whole(name, about.get(name), 0, MOST_COUNTED)
    except InputError as error:
        raise InputError(f"policy={file}: {error}") from None
