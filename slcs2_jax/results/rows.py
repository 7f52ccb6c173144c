"""Files of rows, one to a line, each with a checksum of its own (`crc`).

generations.jsonl has a row for each instance and generation. While a run goes on they stand as they came, which
depends on what shared the batch. A run that ended has them in order of generation and instance, so that equal runs
have equal bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.results.documents import checksum, parse_object
from slcs2_jax.results.files import append, storing, write_whole

_CHECK = "crc"


def row_line(row: Mapping[str, Any]) -> bytes:
    """A row as it is written, with its newline. Raises ValueError for NaN or infinity."""
    return json.dumps({**row, _CHECK: checksum(dict(row))}, allow_nan=False).encode() + b"\n"


def parse_row(line: bytes) -> dict[str, Any]:
    """The row that a line holds; raises InputError if it was damaged."""
    row = parse_object(line)
    said = row.pop(_CHECK, None)
    if said != checksum(row):
        raise InputError("its checksum does not fit: it was damaged or changed by hand")
    return row


def append_rows(path: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Add rows to the file. Raises StorageError, and ValueError for NaN or infinity."""
    append(path, b"".join(map(row_line, rows)))


def read_rows(path: Path) -> list[dict[str, Any]]:
    """All rows in the order of the file; a last line cut short is no row. Raises InputError (without the file's name)
    for a damaged one, and OSError."""
    rows = []
    for number, line in enumerate(_lines(path), start=1):
        try:
            rows.append(parse_row(line))
        except InputError as error:
            raise InputError(f"line {number}: {error}") from None
    return rows


def drop_torn_end(path: Path) -> None:
    """Leave whole lines, so that the next row does not follow a half one. Raises StorageError."""
    if path.exists():
        whole = _joined(_lines(path))
        if _read(path) != whole:
            write_whole(path, lambda file: file.write(whole))


def cut_rows(path: Path, generations: Sequence[int]) -> None:
    """Leave the rows of the first `generations[i]` generations of instance i, and no others.

    Raises InputError (without the file's name) if one of those is missing, damaged or there twice, and StorageError.
    """
    kept: dict[tuple[int, int], bytes] = {}
    for line in _lines(path) if path.exists() else []:
        try:
            place = _place(parse_row(line))
        except InputError:  # beyond the last save nothing is certain to be whole, and nothing is kept
            continue
        if place in kept:
            raise InputError(f"generation {place[0]} of instance {place[1]} is there twice")
        if 0 <= place[1] < len(generations) and place[0] < generations[place[1]]:
            kept[place] = line
    for instance, count in enumerate(generations):
        for generation in range(count):
            if (generation, instance) not in kept:
                raise InputError(f"generation {generation} of instance {instance} is missing or damaged")
    whole = _joined(kept.values())
    if path.exists() and _read(path) != whole:  # also if only the end of a line is missing: the next would follow it
        write_whole(path, lambda file: file.write(whole))


def sort_rows(path: Path) -> None:
    """Put the rows in order of generation and instance. Raises InputError (without the file's name), StorageError."""
    lines = _lines(path)
    ordered = sorted(lines, key=lambda line: _place(parse_row(line)))
    if ordered != lines:
        write_whole(path, lambda file: file.write(_joined(ordered)))


def _joined(lines: Iterable[bytes]) -> bytes:
    return b"".join(line + b"\n" for line in lines)


def _read(path: Path) -> bytes:
    with storing(path, "read"):
        return path.read_bytes()


def _lines(path: Path) -> list[bytes]:
    """Whole lines, without their ends."""
    data = _read(path)
    return data[: data.rfind(b"\n") + 1].split(b"\n")[:-1]


def _place(row: Mapping[str, Any]) -> tuple[int, int]:
    place = row.get("generation"), row.get("instance")
    if not all(isinstance(value, int) and not isinstance(value, bool) and value >= 0 for value in place):
        raise InputError("a row without generation or instance")
    return place  # type: ignore[return-value]
