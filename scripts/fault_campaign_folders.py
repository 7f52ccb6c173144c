"""Hostile run folders: a good one with one thing in it that a stranger could have put there.

`outside` is a folder that no command may touch: it holds good copies of everything, so that whoever follows a link to
it would notice nothing.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import socket
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fault_campaign_given as given
import fault_campaign_suite as suite
import numpy as np

from slcs2_jax.learning.training_folder import FORMAT as TRAINING_FORMAT
from slcs2_jax.results.archive import read_archive
from slcs2_jax.results.documents import checksum
from slcs2_jax.results.policy_file import FORMAT as POLICY_FORMAT
from slcs2_jax.results.run_config import CONFIG, read_config
from slcs2_jax.results.run_folder import (
    CHECKPOINT,
    CHECKPOINT_FORMAT,
    GENERATIONS,
    GRAMMAR,
    KNOWLEDGE,
    SOLUTIONS,
    SUMMARY,
    TIMING,
    checkpoint_limits,
)
from slcs2_jax.results.sweep import SWEEP

BEST = f"{SOLUTIONS}/instance_000_best.npz"
TRANSFER = "transfer"
FILES = (
    *(CONFIG, GENERATIONS, CHECKPOINT, GRAMMAR, KNOWLEDGE, SUMMARY, TIMING, SWEEP, "lock", BEST, "report.html"),
    *(f"{TRANSFER}/{name}" for name in ("deployments.jsonl", "matrix.csv", "transfer.png", "lock")),
)
FOLDERS = (SOLUTIONS, "report", TRANSFER)
NAMES = ("../out", "/tmp/out", "a/../../out", "C:\\out", "link/x", "\x1b[2Jx", "a\nb", "..")
ODD_FOLDERS = (
    "=cmd|' /C calc'!A0",
    "+1+1",
    "@SUM(1)",
    "\\input{secret}",
    "<script>alert(1)</script>",
    "[l](javascript:alert(1))",
    "a|b",
    "[/red]",
    "\x1b[2J\x1b]0;x\x07",
    "a\n# b",
    "$x^{$",
    "-2 `x` ${y}",
)

_NOBODY = 65534  # user and group

Change = Callable[[Path, Path, Path], None]  # the run folder, the file in it, outside


def _gone(file: Path) -> None:
    if file.is_dir() and not file.is_symlink():
        shutil.rmtree(file)
    else:
        file.unlink(missing_ok=True)


def _replaced(make: Callable[[Path, Path], None]) -> Change:
    def change(run: Path, file: Path, outside: Path) -> None:
        _gone(file)
        file.parent.mkdir(exist_ok=True)
        make(file, outside / file.relative_to(run))

    return change


def _with_bytes(data: Callable[[], bytes]) -> Change:
    return _replaced(lambda file, _: file.write_bytes(data()) and None)


def _sparse(file: Path, _: Path) -> None:
    file.touch()
    os.truncate(file, 16 * 2**30)


def _socket(file: Path, _: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one, contextlib.chdir(file.parent):
        one.bind(file.name)  # the whole path may be too long for one


def _no_permission(run: Path, file: Path, outside: Path) -> None:
    if not file.exists():
        file.touch()
    file.chmod(0)


def _another_owner(run: Path, file: Path, outside: Path) -> None:
    """Who lets everybody read it; only root can give a file away."""
    os.chown(file, _NOBODY, _NOBODY)


def _aliases() -> bytes:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [" + ", ".join([f"*a{n - 1}"] * 10) + "]" for n in range(1, 10)]
    return "\n".join(lines).encode()


def _document(kind: str, content: dict[str, Any]) -> bytes:
    whole = {"format": f"slcs2_jax {kind} 1", **content}
    return json.dumps(whole | {"checksum": checksum(whole)}).encode()


def _lists() -> bytes:
    """A summary with the right checksum and twenty million lists."""
    return _document("summary", {"generations": 4, "instances": [[]] * 10_000_000})


def zeros(arrays: dict[str, int], about: str = "", form: str = "") -> bytes:
    """An archive of so many zeros in each entry, a thousandth as long, and what stands beside them."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as made:
        for name, text in (("format", form), ("about", about)):
            with made.open(f"{name}.npy", "w") as entry:
                np.lib.format.write_array(entry, np.array(text))
        for name, size in arrays.items():
            head = io.BytesIO()
            np.lib.format.write_array_header_1_0(head, {"descr": "|u1", "fortran_order": False, "shape": (size,)})
            with made.open(f"{name}.npy", "w", force_zip64=True) as entry:
                entry.write(head.getvalue())
                for _ in range(size // 2**24):
                    entry.write(bytes(2**24))
    return archive.getvalue()


def _many_leaves() -> bytes:
    """A policy with one array of 64 MB at a hundred thousand places."""
    tree = {"dict": {"action": {"list": ["leaf_0"] * 100_000}}}
    about = json.dumps({"policy": given.NAME, "tree": tree, "about": {}})
    return zeros({"leaf_0": 2**26}, about, POLICY_FORMAT)


def _great_checkpoint(run: Path, file: Path, outside: Path) -> None:
    """Of a training: what it says of itself is right, and its first array unpacks to gigabytes."""
    _, about = read_archive(file, TRAINING_FORMAT)
    file.write_bytes(zeros({"leaf_0": 2**32 - 2**24}, json.dumps(about), TRAINING_FORMAT))


def entries(count: int = 200_000) -> bytes:
    """An archive of so many entries."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as made:
        for number in range(count):
            made.writestr(f"{number}.npy", b"")
    return archive.getvalue()


def _member_bomb(run: Path, file: Path, outside: Path) -> None:
    """A checkpoint whose members unpack to gigabytes."""
    arrays, about = read_archive(file, CHECKPOINT_FORMAT, checkpoint_limits(read_config(run).settings))
    packed = zlib.compress(bytes(2**28), 9)
    head = json.dumps({"mask": {"dtype": "|u1", "shape": [2**28], "length": len(packed)}}).encode()
    piece = struct.pack("<I", len(head)) + head + packed
    arrays["0.search.members.data"] = np.frombuffer(piece * 40, np.uint8)
    arrays["0.search.members.length"] = np.full((20, 2), len(piece), np.int64)
    arrays["0.search.members.explorations"] = np.zeros(20, np.int64)
    made = {**arrays, "format": np.array(CHECKPOINT_FORMAT), "about": np.array(json.dumps(about))}
    with file.open("wb") as stream:
        np.savez(stream, **made)


def sweep_of(name: str) -> Change:
    """A sweep that names a run elsewhere."""

    def change(run: Path, file: Path, outside: Path) -> None:
        settings = json.loads((outside / SWEEP).read_bytes())["runs"]
        (run / "link").symlink_to(outside)
        (run / SWEEP).write_bytes(_document("sweep", {"runs": {name: next(iter(settings.values()))}}))

    return change


_EVERY: dict[str, Change] = {
    "link to a good file": _replaced(lambda file, good: file.symlink_to(good)),
    "link to /dev/zero": _replaced(lambda file, good: file.symlink_to("/dev/zero")),
    "link to nothing": _replaced(lambda file, good: file.symlink_to(good.with_name("made"))),
    "another name of a good file": _replaced(lambda file, good: os.link(good, file)),
    "pipe": _replaced(lambda file, good: os.mkfifo(file)),
    "socket": _replaced(_socket),
    "folder": _replaced(lambda file, good: file.mkdir()),
    "huge": _replaced(_sparse),
    "nested": _with_bytes(lambda: b"[" * 10**6),
    "nested mappings": _with_bytes(lambda: b'{"a":' * 10**6),
    "lines": _with_bytes(lambda: b'{"instance": 0, "generation": 0}\n' * 10**6),
    "empty lines": _with_bytes(lambda: b"\n" * 10**7),
    "control characters": _with_bytes(lambda: b"\x1b[2J\x00\x9b" * 1000),
    "no permission": _no_permission,
    "another owner": _another_owner,
}
_YAML: dict[str, Change] = {
    "aliases": _with_bytes(_aliases),
    "long": _with_bytes(lambda: b"a: [" + b"1, " * 10**7 + b"]"),
    "base 60": _with_bytes(lambda: b"a: 1" + b":1" * 400_000),
}
_SOME: dict[str, dict[str, Change]] = {
    CONFIG: _YAML,
    SUMMARY: {"lists": _with_bytes(_lists)},
    CHECKPOINT: {"members that unpack to gigabytes": _member_bomb},
    SWEEP: {f"a run in {name!r}": sweep_of(name) for name in NAMES},
    given.WORLD: _YAML,
    suite.SEARCH: _YAML,
    suite.STRATEGY: _YAML,
    suite.RECORDS[0]: {"lists": _with_bytes(_lists)},
    suite.NET_CHECKPOINT: {"gigabytes in one array": _great_checkpoint},
    suite.NET_CURVE: {"a long line": _with_bytes(lambda: b"1" * 2**29)},
    suite.WALK: {"one array a million times": _with_bytes(_many_leaves)},
    given.GRAMMAR: {"rules that never end": _with_bytes(lambda: b"<a> ::= <a><a>\n" * 10**5)},
}


_PACKED = (
    *(CHECKPOINT, BEST, given.POLICY, suite.WALK, suite.NET_CHECKPOINT, suite.NET_POLICY),
    *(*suite.ARTEFACTS, *suite.RESULTS),
)
_LINKS = ("link to a good file", "link to nothing", "pipe", "no permission", "another owner")


def changes(bombs: dict[str, bytes]) -> list[tuple[str, str, Change]]:
    """Every hostile change: the file, what is done to it, and how."""
    packed = {name: _with_bytes(lambda data=data: data) for name, data in bombs.items()}  # type: ignore[misc]
    files = (*FILES, *given.FILES, *suite.KEPT, *suite.TRAINING)
    folders = (*FOLDERS, *suite.FOLDERS_KEPT, *suite.FOLDERS_TRAINING)
    found = [(file, kind, change) for file in files for kind, change in _EVERY.items()]
    found += [(file, kind, change) for file, some in _SOME.items() for kind, change in some.items()]
    found += [(file, kind, change) for file in _PACKED for kind, change in packed.items()]
    return found + [(folder, kind, _EVERY[kind]) for folder in folders for kind in _LINKS]
