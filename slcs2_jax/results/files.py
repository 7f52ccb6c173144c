"""Files that are whole or absent: written beside their place, forced to the disk, then renamed. No link is followed.

`inside`: the folder that a user named, below which none of a path's folders may be a link (see `config.door`).
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import secrets
import stat
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from slcs2_jax.config.door import SAFE, Folder, must_be_regular, opened_folder, present, read_file
from slcs2_jax.config.errors import InputError, StorageError

_TEMPORARY = ".tmp"
_MOST_COPIED = 2**32  # bytes of a file with two names that is parted from the other before it is added to


@contextlib.contextmanager
def storing(path: Path, action: str = "written") -> Iterator[None]:
    """Turn what the system says about a file into one line: StorageError."""
    try:
        yield
    except StorageError:
        raise
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be {action} ({error.strerror or error}); what was saved before is intact"
        ) from None


@contextlib.contextmanager
def _beside(path: Path, inside: Path | None, action: str = "written") -> Iterator[Folder]:
    """The open folder of a file that is to be changed. What goes wrong is StorageError, or InputError naming it."""
    try:
        with storing(path, action), opened_folder(path.parent, inside) as folder:
            yield folder
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_whole(path: Path, write: Callable[[BinaryIO], object], *, inside: Path | None = None) -> None:
    """Call `write` with a file in memory, whose content takes the place of `path` once it is complete and on the disk.

    A link at `path` is replaced, too. Raises StorageError if the disk refuses; `path` is then as it was.
    """
    content = io.BytesIO()
    write(content)
    with _beside(path, inside) as folder:
        temporary = folder.name(f".{path.name}.{secrets.token_hex(4)}{_TEMPORARY}")
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | SAFE, 0o666, dir_fd=folder.fd)
        try:
            try:
                _put(handle, content.getbuffer())
                os.fsync(handle)
            finally:
                os.close(handle)
            os.replace(temporary, folder.name(path.name), src_dir_fd=folder.fd, dst_dir_fd=folder.fd)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary, dir_fd=folder.fd)
            raise
        _sync_folder(folder)


def append(path: Path, data: bytes, *, inside: Path | None = None) -> None:
    """Add to a file, which is made if it is not there; a file that has another name, too, is parted from it first.

    Raises StorageError; then a part of it may have been added. Raises InputError if it is no regular file.
    """
    with _beside(path, inside) as folder:
        found = folder.state(path.name)
        if found is not None:
            must_be_regular(found)
            if found.st_nlink > 1:
                before = read_file(path, _MOST_COPIED, inside=inside)
                write_whole(path, lambda file: file.write(before), inside=inside)
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | SAFE
        handle = os.open(folder.name(path.name), flags, 0o666, dir_fd=folder.fd)
        try:
            must_be_regular(os.fstat(handle))
            _put(handle, memoryview(data))
        finally:
            os.close(handle)


def sync(path: Path, *, inside: Path | None = None) -> None:
    """Force a file to the disk, if it is there. Raises StorageError, InputError."""
    with _beside(path, inside) as folder:
        found = folder.state(path.name)
        if found is None:
            return
        must_be_regular(found)
        handle = os.open(folder.name(path.name), os.O_RDWR | SAFE, dir_fd=folder.fd)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def delete(path: Path, *, inside: Path | None = None) -> None:
    """Delete a file, if it is there, for good. Raises StorageError."""
    with _beside(path, inside, "deleted") as folder:
        if folder.state(path.name) is not None:
            os.unlink(folder.name(path.name), dir_fd=folder.fd)
            _sync_folder(folder)


def delete_others(place: Path, kept: Collection[str], suffixes: Collection[str], *, inside: Path | None = None) -> None:
    """Delete every file of a folder with one of these suffixes but those kept. Raises StorageError, InputError."""
    with _beside(place / "*", inside, "deleted") as folder:
        for name in folder.names():
            if name not in kept and Path(name).suffix in suffixes:
                _unlink_file(folder, name)


def names_in(path: Path, *, inside: Path) -> list[str]:
    """The names in a folder, in order; none if it is not there. Raises StorageError, InputError if it is a link."""
    if not present(path):
        return []
    with _beside(path / "*", inside, "read") as folder:
        return folder.names()


def make_folder(path: Path, *, inside: Path) -> None:
    """Make a folder in a folder that is there, unless it is there. Raises StorageError, InputError if it is a link."""
    with _beside(path, inside, "made") as folder:
        with contextlib.suppress(FileExistsError):
            os.mkdir(folder.name(path.name), dir_fd=folder.fd)
        with opened_folder(path, inside):
            pass


def remove_leftovers(path: Path) -> None:
    """Delete what a process that was killed while it wrote has left beside the files of a folder."""
    with _beside(path / "*", None, "deleted") as folder:
        for name in folder.names():
            if name.startswith(".") and name.endswith(_TEMPORARY):
                _unlink_file(folder, name)


def _unlink_file(folder: Folder, name: str) -> None:
    """Delete a file, or a link and not what it leads to; a folder stays."""
    found = folder.state(name)
    if found is not None and not stat.S_ISDIR(found.st_mode):
        with contextlib.suppress(FileNotFoundError):
            os.unlink(folder.name(name), dir_fd=folder.fd)


def _put(handle: int, data: memoryview) -> None:
    """Write all of it: the system may take a part at a time."""
    while data:
        data = data[os.write(handle, data) :]


def _sync_folder(folder: Folder) -> None:
    """Force the names in a folder to the disk, where folders can be opened."""
    if folder.fd is not None:
        os.fsync(folder.fd)


def write_text(path: Path, text: str, *, inside: Path | None = None) -> None:
    """A whole text file, UTF-8."""
    write_whole(path, lambda file: file.write(text.encode("utf-8")), inside=inside)


def write_json(path: Path, value: Any, *, inside: Path | None = None) -> None:
    """A whole JSON file; raises ValueError for NaN or infinity."""
    write_text(path, json.dumps(value, indent=2, allow_nan=False) + "\n", inside=inside)
