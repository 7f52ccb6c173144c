"""Files that are whole or absent: written beside their place, forced to the disk, then renamed."""

from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from slcs2_jax.config.errors import StorageError

_TEMPORARY = ".tmp"


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


def write_whole(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Call `write` with a file in memory, whose content takes the place of `path` once it is complete and on the disk.

    Raises StorageError if the disk refuses; `path` is then as it was.
    """
    content = io.BytesIO()
    write(content)
    with storing(path):
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=_TEMPORARY)
        try:
            try:
                _put(handle, content.getbuffer())
                os.fsync(handle)
            finally:
                os.close(handle)
            os.chmod(temporary, 0o666 & ~_umask())
            os.replace(temporary, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        sync_folder(path.parent)


def append(path: Path, data: bytes) -> None:
    """Add to a file, which is made if it is not there. Raises StorageError; then a part of it may have been added."""
    with storing(path):
        handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
        try:
            _put(handle, memoryview(data))
        finally:
            os.close(handle)


def sync(path: Path) -> None:
    """Force a file to the disk. Raises StorageError."""
    with storing(path):
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def delete(path: Path) -> None:
    """Delete a file, if it is there, for good. Raises StorageError."""
    with storing(path, "deleted"):
        if path.exists():
            os.unlink(path)
            sync_folder(path.parent)


def _put(handle: int, data: memoryview) -> None:
    """Write all of it: the system may take a part at a time."""
    while data:
        data = data[os.write(handle, data) :]


def sync_folder(folder: Path) -> None:
    """Force the names in a folder to the disk."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_text(path: Path, text: str) -> None:
    """A whole text file, UTF-8."""
    write_whole(path, lambda file: file.write(text.encode("utf-8")))


def write_json(path: Path, value: Any) -> None:
    """A whole JSON file; raises ValueError for NaN or infinity."""
    write_text(path, json.dumps(value, indent=2, allow_nan=False) + "\n")


def remove_leftovers(folder: Path) -> None:
    """Delete what a process that was killed while it wrote has left beside the files of a folder."""
    for path in folder.glob(f".*{_TEMPORARY}"):
        path.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
