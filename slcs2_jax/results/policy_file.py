"""A policy of any kind in one .npz file without pickles: the name it is registered under, and its parameters.

The file can run no code: its policy is looked up among those that are registered, by plug-ins that the user names.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError
from slcs2_jax.config.arguments import path_of
from slcs2_jax.config.door import present
from slcs2_jax.config.registry import LONGEST_NAME
from slcs2_jax.results.archive import Limits, read_archive, write_archive
from slcs2_jax.results.files import storing

FORMAT = "slcs2_jax policy 1"
_DEEPEST, _MOST_LEAVES = 32, 10_000
_LIMITS = Limits(entries=_MOST_LEAVES + 2, size=2**28)


@dataclass(frozen=True, eq=False)
class SavedPolicy:
    """A policy's registered name, its parameters (nested dictionaries, lists and tuples of arrays), and remarks."""

    name: str
    given: Any
    about: Mapping[str, Any]


def save_policy(
    path: str | Path, name: str, given: Any, about: Mapping[str, Any] | None = None, *, inside: Path | None = None
) -> None:
    """Write a policy's parameters, whole or not at all.

    Args:
        path: of the file, .npz.
        name: that the policy is registered under.
        given: nested dictionaries with text keys, lists and tuples of arrays of numbers.
        about: remarks, JSON-able.
        inside: a folder that the file must lie in, through no link; None for anywhere.

    Raises:
        InputError: something else than these.
        StorageError: the disk refuses.
    """
    arrays: dict[str, NDArray[Any]] = {}
    tree = _pack(given, arrays, 0)
    size = sum(array.nbytes for array in arrays.values())
    if size > _LIMITS.size or len(arrays) > _MOST_LEAVES:
        most = f"{_LIMITS.size:,} bytes in {_MOST_LEAVES:,} arrays"
        raise InputError(f"parameters: {size:,} bytes in {len(arrays):,} arrays; accepted are at most {most}")
    content = {"policy": name, "tree": tree, "about": dict(about or {})}
    write_archive(path_of("path", path), FORMAT, arrays, content, inside=inside)


def load_policy(path: str | Path) -> SavedPolicy:
    """Read a policy's file. Raises InputError naming the file if it is none, damaged, or of another version."""
    file = path_of("policy", path)
    label = f"policy={file}"
    if not present(file):
        raise InputError(f"{label}: no such file; accepted is a policy saved by save_policy")
    try:
        with storing(file, "read"):
            arrays, about = read_archive(file, FORMAT, _LIMITS)
        name = about.get("policy")
        if set(about) != {"policy", "tree", "about"} or not isinstance(about["about"], dict):
            raise InputError("its description is not that of a policy")
        if not isinstance(name, str) or not 0 < len(name) <= LONGEST_NAME:
            raise InputError("its name is no name")
        given = _unpack(about["tree"], arrays, 0)
        if arrays:
            raise InputError("it has arrays that are no parameters")
        return SavedPolicy(name, given, about["about"])
    except InputError as error:
        raise InputError(f"{label}: not a policy saved by slcs2 ({error})") from None


def _pack(given: Any, arrays: dict[str, NDArray[Any]], depth: int) -> Any:
    """The structure as JSON, its leaves put among the arrays under their numbers."""
    if depth > _DEEPEST:
        raise InputError(f"parameters: nested more than {_DEEPEST} deep")
    if isinstance(given, dict):
        if not all(isinstance(key, str) for key in given):
            raise InputError("parameters: a dictionary has a key that is no text")
        return {"dict": {key: _pack(value, arrays, depth + 1) for key, value in given.items()}}
    if isinstance(given, list | tuple):
        kind = "list" if isinstance(given, list) else "tuple"
        return {kind: [_pack(value, arrays, depth + 1) for value in given]}
    leaf = np.asarray(given)
    if leaf.dtype.kind not in "biuf":
        raise InputError(f"parameters: {type(given).__name__}; accepted are dictionaries, lists, tuples and arrays")
    if leaf.dtype.kind == "f" and not np.isfinite(leaf).all():
        raise InputError("parameters: a value is not finite")
    name = f"leaf_{len(arrays)}"
    arrays[name] = leaf
    return name


def _unpack(tree: Any, arrays: dict[str, NDArray[Any]], depth: int) -> Any:
    """The parameters; every array stands in one place, and is taken from `arrays`."""
    if depth > _DEEPEST or len(arrays) > _MOST_LEAVES:
        raise InputError("its parameters are nested too deep, or too many")
    if isinstance(tree, str) and tree in arrays:
        return arrays.pop(tree)
    if isinstance(tree, dict) and len(tree) == 1:
        ((kind, inner),) = tree.items()
        if kind == "dict" and isinstance(inner, dict):
            return {key: _unpack(value, arrays, depth + 1) for key, value in inner.items()}
        if kind in ("list", "tuple") and isinstance(inner, list):
            values = [_unpack(value, arrays, depth + 1) for value in inner]
            return values if kind == "list" else tuple(values)
    raise InputError("its parameters are not arrays in dictionaries, lists and tuples")
