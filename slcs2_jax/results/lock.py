"""One process per run folder. The system's own file lock ends with its process, however that ends."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import socket
import sys
from datetime import datetime
from pathlib import Path
from typing import Any

from slcs2_jax.config.door import SAFE, must_be_regular, opened_folder, read_file
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import show
from slcs2_jax.results.files import storing

LOCK = "lock"
_UNSUPPORTED = {errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL}
_MOST = 4096  # bytes of the record
_SPARE = 64  # open files that a process needs beside the locks it holds

if sys.platform == "win32":
    import msvcrt

    def _system_lock(handle: int) -> None:
        """Lock a byte far behind the record, which others may then still read. Raises BlockingIOError, OSError."""
        os.lseek(handle, 2**30, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            raise BlockingIOError from None

    def _more_files(handle: int) -> None:
        """Windows has no such limit."""

    def _alive(pid: int) -> bool:
        """Asking would end the process: every one counts as alive."""
        return True

else:
    import fcntl
    import resource

    def _system_lock(handle: int) -> None:
        """Lock the file. Raises BlockingIOError if another process has, OSError where there are no locks."""
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _more_files(handle: int) -> None:
        """Every run of a large batch keeps an open file: take what the system allows beyond the usual limit."""
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        if handle + _SPARE > soft != hard:
            more = 2 * soft if hard == resource.RLIM_INFINITY else min(hard, 2 * soft)
            resource.setrlimit(resource.RLIMIT_NOFILE, (more, hard))

    def _alive(pid: int) -> bool:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return False
        except (PermissionError, OverflowError):
            pass
        return True


class FolderLock:
    """Held from `FolderLock(folder)` to `release()`; a context manager. The file says who holds it, for people."""

    def __init__(self, folder: Path) -> None:
        """Take the lock; one that a dead process left is taken over.

        Raises InputError if another process holds it, or it is no file of ours; StorageError if the folder cannot be
        written.
        """
        self.path = folder / LOCK
        while True:
            with storing(self.path):
                self._handle = _open(self.path)
            try:
                self._take(folder)
                if _same_file(self._handle, self.path):
                    break
            except BaseException:
                os.close(self._handle)
                raise
            os.close(self._handle)  # whoever held it has removed the file meanwhile
        _more_files(self._handle)
        owner = {
            "host": socket.gethostname(),
            "pid": os.getpid(),
            "since": datetime.now().astimezone().isoformat(timespec="seconds"),
        }
        with storing(self.path):
            os.ftruncate(self._handle, 0)
            os.lseek(self._handle, 0, os.SEEK_SET)
            os.write(self._handle, json.dumps(owner).encode() + b"\n")

    def _take(self, folder: Path) -> None:
        try:
            _system_lock(self._handle)
        except BlockingIOError:
            raise _held(folder, _owner(self._handle)) from None
        except OSError as error:
            if error.errno not in _UNSUPPORTED:
                raise
            _go_by_record(folder, _owner(self._handle))

    def release(self) -> None:
        """Let go; the file is removed while it is still held, so that nobody's lock is."""
        if self._handle < 0:
            return
        with contextlib.suppress(OSError):
            self.path.unlink()
        os.close(self._handle)
        if sys.platform == "win32":  # no open file can be removed there
            with contextlib.suppress(OSError):
                self.path.unlink()
        self._handle = -1

    def __enter__(self) -> FolderLock:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def is_held(folder: Path) -> bool:
    """Does a process work in the folder, by what its lock says? On another host every process counts as alive.

    Takes no lock, and writes nothing. What is no lock of ours says nothing.
    """
    try:
        owner = _record(read_file(folder / LOCK, _MOST))
    except (OSError, InputError):
        return False
    pid = owner.get("pid")
    if not isinstance(pid, int) or pid <= 0:
        return False
    return owner.get("host") != socket.gethostname() or _alive(pid)


def _open(path: Path) -> int:
    """The lock's file, made if it is not there. Raises InputError for a link or another name of a file elsewhere."""
    try:
        with opened_folder(path.parent) as folder:
            found = folder.state(path.name)
            if found is not None:
                _check(found)
            handle = os.open(folder.name(path.name), os.O_RDWR | os.O_CREAT | SAFE, 0o666, dir_fd=folder.fd)
        try:
            _check(os.fstat(handle))
        except BaseException:
            os.close(handle)
            raise
    except InputError as error:
        raise InputError(f"{path}: {error}; delete it") from None
    return handle


def _check(state: os.stat_result) -> None:
    must_be_regular(state)
    if state.st_nlink > 1 or state.st_size > _MOST:
        raise InputError("is no lock of this program")


def _same_file(handle: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.lstat(path))
    except FileNotFoundError:
        return False


def _owner(handle: int) -> dict[str, Any]:
    try:
        os.lseek(handle, 0, os.SEEK_SET)
        return _record(os.read(handle, _MOST))
    except OSError:
        return {}


def _record(data: bytes) -> dict[str, Any]:
    """Who holds the lock, {} if that is not said."""
    try:
        owner = json.loads(data)
    except (ValueError, RecursionError):
        return {}
    return owner if isinstance(owner, dict) else {}


def _held(folder: Path, owner: dict[str, Any]) -> InputError:
    who = f"process {show(owner.get('pid', '?'))} on {show(owner.get('host', 'an unknown host'))}"
    since = f" since {show(owner['since'])}" if "since" in owner else ""
    return InputError(
        f"run_dir={show(str(folder))}: {who} works in it{since}; accepted is a folder that nobody works in"
    )


def _go_by_record(folder: Path, owner: dict[str, Any]) -> None:
    """Where the file system has no locks: refuse unless the owner is known to be dead."""
    pid = owner.get("pid")
    if not isinstance(pid, int) or pid <= 0 or (owner.get("host") == socket.gethostname() and not _alive(pid)):
        return
    raise InputError(
        f"{_held(folder, owner)} (this file system has no locks: if that process is dead, delete {folder / LOCK})"
    )
