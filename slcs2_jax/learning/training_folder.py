"""The folder of a training: its curve, its checkpoint, its policies; what is there is whole, whenever it is stopped."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from slcs2_jax.config.arguments import path_of, whole
from slcs2_jax.config.door import present, reading
from slcs2_jax.config.errors import InputError
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.policy.trained_network import NAME
from slcs2_jax.results.archive import Limits, check_arrays, read_archive, write_archive
from slcs2_jax.results.files import remove_leftovers, storing, write_whole
from slcs2_jax.results.lock import FolderLock
from slcs2_jax.results.policy_file import save_policy
from slcs2_jax.results.rows import MOST_ROWS, bounded_lines, parse_row, row_line

FORMAT = "slcs2_jax training 2"
CURVE, CHECKPOINT, POLICY = "curve.jsonl", "checkpoint.npz", "policy.npz"
MOST_COUNTED = 2**62  # env-steps, episodes, updates
_MOST_CURVE = 2**28  # bytes
_OF_ANY = Limits(entries=1000, size=2**32)  # training, of which nothing but the description is unpacked


class TrainingFolder:
    """Where a training is saved, and what is noted of it: a row for each line of `curve.jsonl` (`results.rows`).

    Without a folder, nothing is saved.
    """

    def __init__(self, folder: str | Path | None, identity: Mapping[str, Any]) -> None:
        """While it is entered it is there, and this process alone has it.

        Args:
            folder: None for none.
            identity: what the training is, JSON-able: a folder that holds another is refused.
        """
        self._curve: list[bytes] = []
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

    def note(self, row: Mapping[str, Any]) -> None:
        """A further row of the curve, of finite numbers, among them `env_steps`, more than before."""
        self._curve.append(row_line(row))

    def last(self, count: int) -> list[dict[str, Any]]:
        """The last rows of the curve, at most so many."""
        return [parse_row(line) for line in self._curve[-count:]]

    def load(self, like: Any, counters: Mapping[str, Any]) -> tuple[Any, dict[str, Any]] | None:
        """What was saved, if anything was; the curve becomes that of then.

        Args:
            like: a pytree of what is saved, for its structure, shapes and types.
            counters: such as are saved, for their names and kinds: `env_steps`, other whole numbers, lists of such.

        Returns:
            The same with what was saved, NumPy arrays, and the counters.

        Raises:
            InputError: the folder holds another training, or a damaged one.
        """
        if self._path is None or not present(self._path / CHECKPOINT):
            return None
        file = self._path / CHECKPOINT
        expected = {f"leaf_{place}": leaf for place, leaf in enumerate(map(np.asarray, jax.tree.leaves(like)))}
        limits = Limits(entries=len(expected) + 2, size=sum(leaf.nbytes for leaf in expected.values()))
        try:
            with storing(file, "read"):
                self._check_same(read_archive(file, FORMAT, _OF_ANY, wanted=lambda name: False)[1])
                arrays, about = read_archive(file, FORMAT, limits)
            check_arrays(arrays, {name: (leaf.dtype, leaf.shape) for name, leaf in expected.items()})
            lines = whole("lines", about["lines"], 0, MOST_ROWS)
            _check_counters(about["counters"], counters)
        except InputError as error:
            raise InputError(f"{file}: {error}") from None
        self._load_curve(self._path / CURVE, lines, about["counters"]["env_steps"])
        found = [arrays[name] for name in expected]
        return jax.tree.unflatten(jax.tree.structure(like), found), about["counters"]

    def _check_same(self, about: Mapping[str, Any]) -> None:
        """Raise InputError unless this describes the training of this folder."""
        if set(about) != {"identity", "counters", "lines"} or not isinstance(about["identity"], dict):
            raise InputError("its description is not that of a training")
        odd = [name for name in self._identity if about["identity"].get(name) != self._identity[name]]
        if odd:
            raise InputError(f"is of another training ({', '.join(odd)} differ); accepted is another folder")

    def _load_curve(self, path: Path, lines: int, env_steps: int) -> None:
        """The first so many lines, up to so many env-steps: the process was killed before it saved what follows."""
        found: list[bytes] = []
        try:
            if present(path):
                with storing(path, "read"), reading(path, _MOST_CURVE) as file:
                    found = list(itertools.islice(bounded_lines(file, MOST_ROWS), lines))
            counts = [0, *(whole("env_steps", parse_row(line).get("env_steps"), 0, MOST_COUNTED) for line in found)]
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        climbs = all(before < after for before, after in itertools.pairwise(counts))
        if len(found) != lines or not climbs or counts[-1] != env_steps or (found and found[-1][-1:] != b"\n"):
            raise InputError(f"{path}: has not the {lines} whole lines that the checkpoint goes with")
        self._curve = found

    def save(self, tree: Any, counters: Mapping[str, Any]) -> None:
        """The curve, then the checkpoint that says how much of the curve goes with it."""
        if self._path is None:
            return
        arrays = {f"leaf_{place}": np.asarray(leaf) for place, leaf in enumerate(jax.tree.leaves(tree))}
        about = {"identity": self._identity, "counters": dict(counters), "lines": len(self._curve)}
        write_whole(self._path / CURVE, lambda file: file.writelines(self._curve))
        write_archive(self._path / CHECKPOINT, FORMAT, arrays, about)

    def save_policy(self, policy: BoundPolicy, about: Mapping[str, Any], name: str) -> None:
        """A policy as it is now, to be named by policy=FILE."""
        if self._path is not None:
            save_policy(self._path / name, NAME, policy.given, about)


def _check_counters(found: object, like: Mapping[str, Any]) -> None:
    """Raise InputError unless these are counts, and lists of as many, by the same names."""
    if not isinstance(found, dict) or set(found) != set(like):
        raise InputError("its counters are not those of this training")
    for name, usual in like.items():
        counts = found[name] if isinstance(usual, list) else [found[name]]
        if not isinstance(counts, list) or len(counts) != (len(usual) if isinstance(usual, list) else 1):
            raise InputError(f"{name} is no list of {len(usual)} counts")
        for count in counts:
            whole(name, count, 0, MOST_COUNTED)
