"""Arrays and a description in one .npz file without pickles, read without believing anything that it says of itself."""

from __future__ import annotations

import io
import json
import math
import os
import struct
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.door import reading, telling_damage
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import show
from slcs2_jax.results.documents import check_format, parse_object
from slcs2_jax.results.files import write_whole

_FORMAT, _ABOUT = "format", "about"
_PER_ENTRY = 1024  # bytes, at most, of an entry's heads in the archive
_END = struct.Struct("<4s4H2LH")  # of a .zip: signature, disks, entries, size and place of the directory, comment
_END_64 = struct.Struct("<4sQ2H2L4Q")  # the same where there are more entries or bytes than that can hold
_LOCATOR_64 = struct.Struct("<4sLQL")


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What a file of a format can hold: entries, bytes of all of them, and letters of its description.

    compressed: may its entries be?
    """

    entries: int = 64
    size: int = 2**26
    about: int = 2**20
    compressed: bool = True

    @property
    def file(self) -> int:
        """Bytes of the whole file: what does not compress is hardly longer."""
        return self.size + 4 * self.about + self.entries * _PER_ENTRY + self.size // 1000


_USUAL = Limits()


def write_archive(
    path: Path,
    form: str,
    arrays: Mapping[str, NDArray[Any]],
    about: Mapping[str, Any],
    *,
    compressed: bool = True,
    inside: Path | None = None,
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
    write_whole(path, lambda file: save(file, **entries), inside=inside)


def read_archive(
    path: Path,
    form: str,
    limits: Limits = _USUAL,
    *,
    wanted: Callable[[str], bool] = lambda name: True,
    inside: Path | None = None,
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Arrays and description of a file that `write_archive` wrote; of the arrays, those whose names are `wanted`.

    Raises InputError (without the file's name) if it is none, another, a larger or a damaged one: every entry has a
    checksum. Raises OSError.
    """
    with reading(path, limits.file, inside=inside) as file:
        size = os.fstat(file.fileno()).st_size
        with telling_damage():
            if not _directory_fits(file, size, limits.entries):
                raise InputError("no .npz archive, or cut short")
            with zipfile.ZipFile(file) as archive:
                found = _checked(archive, size, limits)
                kept = {
                    name: _array(archive, info)
                    for name, info in found.items()
                    if name in (_FORMAT, _ABOUT) or wanted(name)
                }
    for name in (_FORMAT, _ABOUT):
        if name not in kept or kept[name].dtype.kind != "U" or kept[name].shape != ():
            raise InputError(f"its {name} is missing or no text")
    check_format(str(kept.pop(_FORMAT)), form)
    about = parse_object(str(kept.pop(_ABOUT)).encode("utf-8", "surrogatepass"))
    return kept, about


def _directory_fits(file: BinaryIO, size: int, entries: int) -> bool:
    """Is the archive's directory where it must be, and of a size that so many entries can have?

    To be asked first: the library reads the whole of it.
    """
    if size < _END.size:
        return False
    file.seek(size - _END.size)
    end = _END.unpack(file.read(_END.size))
    if end[0] != b"PK\5\6" or end[7] != 0:
        return False
    length = end[5]
    if 0xFFFFFFFF in end[5:7] or 0xFFFF in end[3:5]:
        file.seek(max(0, size - _END.size - _LOCATOR_64.size))
        locator = _LOCATOR_64.unpack(file.read(_LOCATOR_64.size))
        if locator[0] == b"PK\6\7":
            file.seek(min(locator[2], size))
            length = _END_64.unpack(file.read(_END_64.size))[8]
    file.seek(0)
    return bool(length <= entries * _PER_ENTRY)


def _checked(archive: zipfile.ZipFile, size: int, limits: Limits) -> dict[str, zipfile.ZipInfo]:
    """The entries by name; raises InputError for what no file of its format can hold. Nothing is unpacked."""
    infos = archive.infolist()
    kinds = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)[: 1 + limits.compressed]
    if len(infos) > limits.entries:
        raise InputError(f"{len(infos)} entries; accepted are at most {limits.entries}")
    found = {}
    for info in infos:
        if not info.filename.endswith(".npy") or info.compress_type not in kinds or info.flag_bits & 1:
            raise InputError(f"entry {show(info.filename)} is no array")
        name = info.filename.removesuffix(".npy")
        most = limits.size + _PER_ENTRY if name != _ABOUT else 4 * limits.about + _PER_ENTRY  # four bytes to a letter
        if info.file_size > most or info.compress_size > size:
            raise InputError(f"entry {show(info.filename)} is too large")
        if name in found:
            raise InputError("an entry is there twice")
        found[name] = info
    total = sum(info.file_size for name, info in found.items() if name != _ABOUT)
    if total > limits.size + limits.entries * _PER_ENTRY:
        raise InputError(f"would take {total:,} bytes; accepted are at most {limits.size:,}")
    if sum(info.compress_size for info in infos) > size:
        raise InputError("its entries overlap")
    return found


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    """One entry, of the size that its head says: it was looked at before memory is taken for it."""
    with archive.open(info) as entry:
        raw = io.BytesIO(entry.read(info.file_size))
        if entry.read(1):
            raise InputError(f"entry {show(info.filename)} is longer than it says")
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
