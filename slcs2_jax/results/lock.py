"""One process per run folder. The system's own file lock ends with its process, however that ends."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import resource
import socket
from datetime import datetime
from pathlib import Path
from typing import Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import show
from slcs2_jax.results.files import storing

LOCK = "lock"
_UNSUPPORTED = {errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL}


class FolderLock:
    """Held from `FolderLock(folder)` to `release()`; a context manager. The file says who holds it, for people."""

    def __init__(self, folder: Path) -> None:
        """Take the lock; one that a dead process left is taken over.

        Raises InputError if another process holds it, StorageError if the folder cannot be written.
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
        owner = {
            "host": socket.gethostname(),
            "pid": os.getpid(),
            "since": datetime.now().astimezone().isoformat(timespec="seconds"),
        }
        with storing(self.path):
            os.ftruncate(self._handle, 0)
            os.pwrite(self._handle, json.dumps(owner).encode() + b"\n", 0)

    def _take(self, folder: Path) -> None:
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
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
        self._handle = -1

    def __enter__(self) -> FolderLock:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def is_held(folder: Path) -> bool:
    """Does a process work in the folder, by what its lock says? On another host every process counts as alive.

    Takes no lock, and writes nothing.
    """
    try:
        owner = json.loads((folder / LOCK).read_bytes()[:4096])
    except (OSError, ValueError):
        return False
    pid = owner.get("pid") if isinstance(owner, dict) else None
    if not isinstance(pid, int) or pid <= 0:
        return False
    return owner.get("host") != socket.gethostname() or _alive(pid)


def _open(path: Path) -> int:
    flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC
    try:
        return os.open(path, flags, 0o666)
    except OSError as error:
        if error.errno != errno.EMFILE:
            raise
    # every run of a large batch keeps one open file: take what the system allows beyond the usual limit
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    more = 2 * soft if hard == resource.RLIM_INFINITY else hard
    resource.setrlimit(resource.RLIMIT_NOFILE, (more, hard))
    return os.open(path, flags, 0o666)


def _same_file(handle: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except FileNotFoundError:
        return False


def _owner(handle: int) -> dict[str, Any]:
    try:
        owner = json.loads(os.pread(handle, 4096, 0))
    except (OSError, ValueError):
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


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        pass
    return True
