"""Arrays and a description in one .npz file without pickles, read without believing anything that it says of itself."""

from __future__ import annotations

import io
import json
import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import show
from slcs2_jax.results.documents import check_format, parse_object
from slcs2_jax.results.files import write_whole

_FORMAT, _ABOUT = "format", "about"
_LARGEST = 2**31  # bytes of one array that a file may hold

# What reading a damaged archive can raise, by the readers of its layers (RuntimeError: said to be encrypted).
_DAMAGE = (
    OSError, EOFError, ValueError, KeyError, IndexError, TypeError, OverflowError, MemoryError, RuntimeError,
    SyntaxError, struct.error, tokenize.TokenError, zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error,
)  # fmt: skip


def write_archive(
    path: Path, form: str, arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any], *, compressed: bool = True
) -> None:
    """Write arrays and a JSON-able description, whole or not at all; the same content gives the same bytes.

    Raises StorageError, and ValueError for NaN or infinity in the description.
    """
    entries: dict[str, Any] = {
        **arrays,
        _FORMAT: np.array(form),
        _ABOUT: np.array(json.dumps(about, allow_nan=False)),
    }
    save = np.savez_compressed if compressed else np.savez
    write_whole(path, lambda file: save(file, **entries))


def read_archive(path: Path, form: str) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Arrays and description of a file that `write_archive` wrote.

    Raises InputError (without the file's name) if it is none, another or a damaged one: every entry has a checksum.
    """
    try:
        if not zipfile.is_zipfile(path):
            raise InputError("no .npz archive, or cut short")
        with zipfile.ZipFile(path) as archive:
            entries = {info.filename.removesuffix(".npy"): _array(archive, info) for info in archive.infolist()}
            if len(entries) != len(archive.infolist()):
                raise InputError("an entry is there twice")
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(f"damaged or cut short: {show(str(error))}") from None
    for name in (_FORMAT, _ABOUT):
        if name not in entries or entries[name].dtype.kind != "U" or entries[name].shape != ():
            raise InputError(f"its {name} is missing or no text")
    check_format(str(entries.pop(_FORMAT)), form)
    about = parse_object(str(entries.pop(_ABOUT)).encode("utf-8", "surrogatepass"))
    return entries, about


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    """One entry, its size looked at before memory is taken for it."""
    if info.file_size > _LARGEST or not info.filename.endswith(".npy"):
        raise InputError(f"entry {show(info.filename)} is too large or no array")
    raw = io.BytesIO(archive.read(info))
    version = np.lib.format.read_magic(raw)
    if version != (1, 0):
        raise InputError(f"entry {show(info.filename)} has version {version} of its format; accepted is (1, 0)")
    shape, _, dtype = np.lib.format.read_array_header_1_0(raw)
    if dtype.hasobject or math.prod(shape) * dtype.itemsize != info.file_size - raw.tell():
        raise InputError(f"entry {show(info.filename)} is not as long as its header says")
    raw.seek(0)
    return np.lib.format.read_array(raw, allow_pickle=False)


def check_arrays(arrays: Mapping[str, NDArray[Any]], expected: Mapping[str, tuple[Any, tuple[int, ...]]]) -> None:
    """Raise InputError unless the arrays are exactly those expected, by name, type and shape."""
    if set(arrays) != set(expected):
        odd = sorted(set(arrays) ^ set(expected))
        raise InputError(f"its entries are not those expected ({show(', '.join(odd))})")
    for name, (dtype, shape) in expected.items():
        if arrays[name].dtype != dtype or arrays[name].shape != shape:
            found = f"{arrays[name].dtype}{list(arrays[name].shape)}"
            raise InputError(f"{name} is {found}; accepted is {np.dtype(dtype)}{list(shape)}")
