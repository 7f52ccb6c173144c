"""The one door for files: whatever is read or written passes here, so that a stranger's folder can do no harm.

Only regular files are opened: no links, pipes, devices or sockets. A file is looked at before it is opened and again
once it is open, relative to the descriptor of its folder where the system has such, so that nothing can be put in its
place in between. The folder that a user names may be a link itself; what lies `inside` it may not.

What is refused is an InputError without the file's name, which the caller knows how to say.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import BinaryIO

from slcs2_jax.config.errors import InputError, StorageError, show

# Not followed, not waited for, not handed on to other programs; each flag where the system has it.
SAFE = 0
for _flag in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_NOCTTY", "O_BINARY", "O_NOINHERIT"):
    SAFE |= getattr(os, _flag, 0)
_FOLDER = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_CLOEXEC", 0)
_RELATIVE = os.open in os.supports_dir_fd

MOST_FOLDERS = 100_000  # below a folder that is searched for runs
DEEPEST = 32  # of those

_KINDS = (
    (stat.S_ISLNK, "a link"),
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


@dataclass(frozen=True)
class Folder:
    """An open folder. `name(x)` with `dir_fd=fd` is its entry x for functions of `os`."""

    path: Path
    fd: int | None

    def name(self, entry: str) -> str:
        """The entry as `os` wants it: its name alone beside a descriptor, else the whole path."""
        return entry if self.fd is not None else str(self.path / entry)

    def state(self, entry: str) -> os.stat_result | None:
        """What the entry is, without following it; None if there is none. Raises OSError."""
        try:
            return os.stat(self.name(entry), dir_fd=self.fd, follow_symlinks=False)
        except FileNotFoundError:
            return None

    def names(self) -> list[str]:
        """Its entries in order. Raises OSError."""
        return sorted(os.listdir(self.path if self.fd is None else self.fd))


@contextlib.contextmanager
def opened_folder(path: Path, inside: Path | None = None) -> Iterator[Folder]:
    """A folder; none of its parents below `inside` may be a link. Raises InputError, OSError."""
    parts = () if inside is None else path.relative_to(inside).parts
    if not _RELATIVE:
        for count, part in enumerate(parts, start=1):
            _must_be_folder(part, os.lstat(Path(inside or "", *parts[:count])))
        yield Folder(path, None)
        return
    handle = os.open(path if inside is None else inside, _FOLDER)
    try:
        for part in parts:
            _must_be_folder(part, os.stat(part, dir_fd=handle, follow_symlinks=False))
            following = os.open(part, _FOLDER | SAFE, dir_fd=handle)
            os.close(handle)
            handle = following
        yield Folder(path, handle)
    finally:
        os.close(handle)


@contextlib.contextmanager
def reading(path: Path, most: int, *, inside: Path | None = None) -> Iterator[BinaryIO]:
    """A regular file of at most `most` bytes, open to be read. Raises InputError, OSError."""
    with opened_folder(path.parent, inside) as folder:
        state = os.stat(folder.name(path.name), dir_fd=folder.fd, follow_symlinks=False)
        must_be_regular(state)
        handle = os.open(folder.name(path.name), os.O_RDONLY | SAFE, dir_fd=folder.fd)
    with os.fdopen(handle, "rb") as file:
        state = os.fstat(handle)
        must_be_regular(state)
        if state.st_size > most:
            raise InputError(f"{state.st_size:,} bytes; accepted are at most {most:,}")
        yield file


def read_file(path: Path, most: int, *, inside: Path | None = None) -> bytes:
    """The content of a regular file of at most `most` bytes, as long as it was when opened.

    Raises InputError, OSError.
    """
    with reading(path, most, inside=inside) as file:
        return file.read(os.fstat(file.fileno()).st_size)


def must_be_regular(state: os.stat_result) -> None:
    """Raise InputError saying what it is, if it is no regular file."""
    _must_be(state, stat.S_ISREG, "a regular file")


def _must_be_folder(name: str, state: os.stat_result) -> None:
    try:
        _must_be(state, stat.S_ISDIR, "a folder")
    except InputError as error:
        raise InputError(f"its folder {show(name)} {error}") from None


def _must_be(state: os.stat_result, test: Callable[[int], bool], accepted: str) -> None:
    if not test(state.st_mode):
        what = next((word for is_one, word in _KINDS if is_one(state.st_mode)), "a file")
        raise InputError(f"is {what}; accepted is {accepted}")


def present(path: Path) -> bool:
    """Is anything of this name there, be it a link to nothing? Raises StorageError if the system does not say."""
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise StorageError(f"{path}: cannot be looked at ({error.strerror})") from None
    except ValueError:  # a name that no file can have
        return False
    return True


def name_inside(name: object) -> PurePosixPath:
    """A relative path that stays in its folder; raises InputError for any other, and for what no path should hold."""
    if not isinstance(name, str) or not name or not name.isprintable():
        raise InputError(f"the name {show(ascii(name))}; accepted is the name of a folder below this one")
    found = PurePosixPath(name.replace("\\", "/"))
    if found.is_absolute() or PureWindowsPath(name).anchor or ".." in found.parts:
        raise InputError(f"the name {show(name)}; accepted is the name of a folder below this one")
    return found


def check_below(root: Path, path: Path) -> None:
    """Raise InputError if what there is on the way from `root` to the folder `path` is a link or no folder."""
    place = root
    for part in path.relative_to(root).parts:
        place = place / part
        if not present(place):
            return
        try:
            _must_be(os.lstat(place), stat.S_ISDIR, "a folder")
        except InputError as error:
            raise InputError(f"{place}: {error}") from None


def folders_below(root: Path, passed: list[str] | None = None) -> Iterator[Path]:
    """`root` and every folder below it, in order; links are not followed.

    passed: gets a line for each folder that cannot be looked into, and for each link to one. Raises InputError for more
    folders, or deeper ones, than any study has.
    """
    passed = [] if passed is None else passed
    count, waiting = 0, [(root, 0)]
    while waiting:
        folder, depth = waiting.pop()
        count += 1
        if count > MOST_FOLDERS or depth > DEEPEST:
            raise InputError(
                f"folder={root}: accepted are at most {MOST_FOLDERS:,} folders below it, nested at most {DEEPEST} deep"
            )
        yield folder
        below = []
        try:
            with os.scandir(folder) as entries:
                for entry in entries:
                    if entry.is_dir(follow_symlinks=False):
                        below.append(Path(entry.path))
                    elif entry.is_symlink() and entry.is_dir():
                        passed.append(f"{entry.path}: is a link to a folder")
        except OSError as error:
            passed.append(f"{folder}: cannot be looked into ({error.strerror})")
        waiting += [(path, depth + 1) for path in sorted(below, reverse=True)]


@contextlib.contextmanager
def telling_damage(what: str = "damaged or cut short") -> Iterator[None]:
    """Whatever reading foreign bytes raises is said of them: InputError, one line.

    To be entered around readers that do nothing else: of a text that is not what it should be, the libraries underneath
    raise dozens of kinds of errors.
    """
    try:
        yield
    except (InputError, StorageError):
        raise
    except Exception as error:
        raise InputError(f"{what}: {show(str(error) or type(error).__name__)}") from None
