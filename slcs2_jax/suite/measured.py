"""What an entry came to in a world: one small file for each, written whole or not at all.

ROOT/results/ENTRY/WORLD.npz holds packets delivered and time-steps of every deployment in the test worlds; fitness
follows from them. ROOT/validation/ENTRY/WORLD.npz is the same for the validation worlds, by which entries are tuned.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError
from slcs2_jax.config.door import check_below, present
from slcs2_jax.config.errors import show
from slcs2_jax.results.archive import Limits, check_arrays, read_archive, write_archive
from slcs2_jax.results.files import make_folder, names_in, storing
from slcs2_jax.suite.worlds import FOLDER, SuiteWorld

FOLDERS = {"test": "results", "validation": "validation"}  # by split
FORMAT = "slcs2_jax suite result 1"
_LIMITS = Limits(entries=6, size=2**24, about=2**16)
_ABOUT: Mapping[str, Any] = {
    "version": str, "world": str, "sha256": str, "entry": str, "title": str, "field": str, "digest": str,
    "split": str, "episodes": int, "env_steps": int,
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Measured:
    """R trainings (1 of what is not trained) in S worlds of a split, D deployments in each.

    Attributes:
        version, world, sha256: of the suite, of the kind of world, and its checksum.
        entry, title, field, digest: what was deployed; the digest is over all that was.
        split: test, or validation.
        seeds: int64 [S], of the worlds.
        delivered, steps: int32 [R, S, D].
        episodes, env_steps: that its trainings spent in all, validation included; 0 of what is not trained.
    """

    version: str
    world: str
    sha256: str
    entry: str
    title: str
    field: str
    digest: str
    split: str
    seeds: NDArray[np.int64]
    delivered: NDArray[np.int32]
    steps: NDArray[np.int32]
    episodes: int = 0
    env_steps: int = 0

    def fitness(self, world: SuiteWorld) -> NDArray[np.float64]:
        """float64 [R, S, D]: share delivered less share of time used (paper, fitness equation)."""
        return self.delivered / world.packets - self.steps / world.time_limit

    def save(self, root: Path) -> None:
        """Write the file of this entry and world below a folder. Raises StorageError."""
        path = _path(root, self.split, self.entry, self.world)
        make_folders(root, path.parent)
        about = {name: getattr(self, name) for name in _ABOUT}
        arrays: dict[str, NDArray[Any]] = {"seeds": self.seeds, "delivered": self.delivered, "steps": self.steps}
        write_archive(path, FORMAT, arrays, about, inside=root)


def load(root: Path, entry: str, world: SuiteWorld, split: str = "test") -> Measured | None:
    """What a folder holds of an entry in a world; None for nothing.

    Raises InputError naming the file if it is damaged, of another version, or of other worlds than these, or the folder
    on the way that is a link.
    """
    path = _path(root, split, entry, world.name)
    check_below(root, path.parent)
    if not present(path):
        return None
    try:
        with storing(path, "read"):
            arrays, about = read_archive(path, FORMAT, _LIMITS, inside=root)
        found = _checked(arrays, about, world, split)
    except InputError as error:
        raise InputError(f"{path}: {error}; delete it, and slcs2 suite evaluate makes it again") from None
    if (found.entry, found.world, found.split) != (entry, world.name, split):
        raise InputError(f"{path}: is that of {show(found.entry)} in {show(found.world)}")
    return found


def _checked(arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any], world: SuiteWorld, split: str) -> Measured:
    if set(about) != set(_ABOUT) or any(type(about[name]) is not kind for name, kind in _ABOUT.items()):
        raise InputError("its description is not that of a result")
    if about["version"] != world.version or about["sha256"] != world.sha256:
        raise InputError(f"measured in other worlds than those of {world.version}")
    shape = np.shape(arrays.get("delivered", ()))
    if len(shape) != 3 or 0 in shape:
        raise InputError(f"delivered has shape {list(shape)}; accepted are trainings, worlds and deployments")
    check_arrays(arrays, {"seeds": (np.int64, shape[1:2]), **dict.fromkeys(("delivered", "steps"), (np.int32, shape))})
    delivered, steps, seeds = (arrays[name] for name in ("delivered", "steps", "seeds"))
    if not (delivered.min() >= 0 and delivered.max() <= world.packets):
        raise InputError(f"delivered: a value beyond 0 to {world.packets}")
    if not (steps.min() >= 0 and steps.max() <= world.time_limit):
        raise InputError(f"steps: a value beyond 0 to {world.time_limit}")
    if len(set(seeds.tolist())) < len(seeds) or not set(seeds.tolist()) <= set(world.seeds_of(split)):
        raise InputError(f"seeds: others than the {split} seeds, or one twice")
    if about["episodes"] < 0 or about["env_steps"] < 0:
        raise InputError("episodes, env_steps: below 0")
    return Measured(seeds=seeds, delivered=delivered, steps=steps, **about)


def find(entry: str, world: SuiteWorld, roots: Sequence[Path], split: str = "test") -> Measured | None:
    """The first that one of these folders holds. Raises InputError naming a damaged file."""
    for root in roots:
        found = load(root, entry, world, split)
        if found is not None:
            return found
    return None


def entries_in(root: Path, split: str = "test") -> list[str]:
    """The names of entries with results below a folder, in order; what is neither folder nor link is none.

    Raises InputError if the folder of results is a link, StorageError if it cannot be read.
    """
    folder = root / FOLDERS[split]
    return [name for name in names_in(folder, inside=root) if (folder / name).is_dir() or (folder / name).is_symlink()]


def shipped_root() -> Path:
    """The folder of artefacts and results that the suite comes with."""
    return Path(str(resources.files(__package__) / FOLDER))


def make_folders(root: Path, folder: Path) -> None:
    """Make a folder below `root`, which is made too, and those on the way. Raises StorageError, InputError."""
    with storing(root, "made"):
        root.mkdir(parents=True, exist_ok=True)
    place = root
    for part in folder.relative_to(root).parts:
        place = place / part
        make_folder(place, inside=root)


def _path(root: Path, split: str, entry: str, world: str) -> Path:
    return root / FOLDERS[split] / entry / f"{world}.npz"
