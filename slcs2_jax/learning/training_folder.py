"""The folder of a training: its curve, its checkpoint, its policies; what is there is whole, whenever it is stopped."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from slcs2_jax.config.arguments import path_of
from slcs2_jax.config.door import present, read_file
from slcs2_jax.config.errors import InputError
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.policy.trained_network import NAME
from slcs2_jax.results.archive import Limits, read_archive, write_archive
from slcs2_jax.results.files import remove_leftovers, storing, write_text
from slcs2_jax.results.lock import FolderLock
from slcs2_jax.results.policy_file import save_policy

FORMAT = "slcs2_jax training 1"
CURVE, CHECKPOINT, POLICY = "curve.jsonl", "checkpoint.npz", "policy.npz"
_LIMITS = Limits(entries=1000, size=2**32)
_MOST_CURVE = 2**30  # bytes


class TrainingFolder:
    """Where a training is saved; without a folder, nothing is.

    curve: what was noted of it, one JSON object for each line of `curve.jsonl`.
    """

    def __init__(self, folder: str | Path | None, identity: Mapping[str, Any]) -> None:
        """While it is entered it is there, and this process alone has it.

        Args:
            folder: None for none.
            identity: what the training is, JSON-able: a folder that holds another is refused.
        """
        self.curve: list[dict[str, Any]] = []
        self._identity = json.loads(json.dumps(identity))
        self._path = None if folder is None else path_of("folder", folder)
        self._lock: FolderLock | None = None

    def __enter__(self) -> TrainingFolder:
        """Take it. Raises InputError if another process has it, StorageError if the disk refuses."""
        if self._path is not None:
            with storing(self._path, "made"):
                self._path.mkdir(parents=True, exist_ok=True)
            self._lock = FolderLock(self._path)
            remove_leftovers(self._path)
        return self

    def __exit__(self, *_: object) -> None:
        if self._lock is not None:
            self._lock.release()

    def load(self, like: Any) -> tuple[Any, dict[str, Any]] | None:
        """What was saved, if anything was; the curve becomes that of then.

        Args:
            like: a pytree of what is saved, for its structure, shapes and types.

        Returns:
            The same with what was saved, NumPy arrays, and the counters.

        Raises:
            InputError: the folder holds another training, or a damaged one.
        """
        if self._path is None or not present(self._path / CHECKPOINT):
            return None
        try:
            with storing(self._path / CHECKPOINT, "read"):
                arrays, about = read_archive(self._path / CHECKPOINT, FORMAT, _LIMITS)
            if set(about) != {"identity", "counters", "lines"}:
                raise InputError("its description is not that of a training")
        except InputError as error:
            raise InputError(f"{self._path / CHECKPOINT}: no training saved by slcs2 ({error})") from None
        if about["identity"] != self._identity:
            odd = [name for name in self._identity if about["identity"].get(name) != self._identity[name]]
            raise InputError(
                f"folder={self._path}: holds another training ({', '.join(odd)} differ); accepted is another folder"
            )
        leaves, structure = jax.tree.flatten(like)
        found = [arrays.get(f"leaf_{place}") for place in range(len(leaves))]
        if not all(_alike(one, leaf) for one, leaf in zip(found, leaves, strict=True)):
            raise InputError(f"{self._path / CHECKPOINT}: arrays of other shapes; accepted are those of this training")
        self._load_curve(about["lines"])
        return jax.tree.unflatten(structure, found), about["counters"]

    def _load_curve(self, lines: int) -> None:
        assert self._path is not None  # for the type checker
        path = self._path / CURVE
        try:
            text = read_file(path, _MOST_CURVE).decode().splitlines() if present(path) else []
            found = [json.loads(line) for line in text[:lines]]
        except (ValueError, OSError):
            found = []
        if len(found) != lines:
            raise InputError(f"{path}: has not the {lines} whole lines that the checkpoint goes with")
        self.curve = found

    def save(self, tree: Any, counters: Mapping[str, Any]) -> None:
        """The curve, then the checkpoint that says how much of the curve goes with it."""
        if self._path is None:
            return
        arrays = {f"leaf_{place}": np.asarray(leaf) for place, leaf in enumerate(jax.tree.leaves(tree))}
        about = {"identity": self._identity, "counters": dict(counters), "lines": len(self.curve)}
        write_text(self._path / CURVE, "".join(json.dumps(line) + "\n" for line in self.curve))
        write_archive(self._path / CHECKPOINT, FORMAT, arrays, about)

    def save_policy(self, policy: BoundPolicy, about: Mapping[str, Any], name: str) -> None:
        """A policy as it is now, to be named by policy=FILE."""
        if self._path is not None:
            save_policy(self._path / name, NAME, policy.given, about)


def _alike(one: Any, leaf: Any) -> bool:
    return one is not None and one.shape == np.shape(leaf) and one.dtype == np.asarray(leaf).dtype
