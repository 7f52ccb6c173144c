"""Files of rows, one to a line, each with a checksum of its own (`crc`).

generations.jsonl has a row for each instance and generation. While a run goes on they stand as they came, which
depends on what shared the batch. A run that ended has them in order of generation and instance, so that equal runs
have equal bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from slcs2_jax.config.door import present, reading
from slcs2_jax.config.errors import InputError
from slcs2_jax.results.documents import check_sum, checksum, parse_object
from slcs2_jax.results.files import append, storing, write_whole

MOST_ROWS = 2_000_000  # of a file: some 600 MB, and 3 GB of memory
LONGEST_ROW = 4096  # bytes
_CHECK = "crc"


def row_line(row: Mapping[str, Any]) -> bytes:
    """A row as it is written, with its newline. Raises ValueError for NaN or infinity."""
    return json.dumps({**row, _CHECK: checksum(dict(row))}, allow_nan=False).encode() + b"\n"


def parse_row(line: bytes) -> dict[str, Any]:
    """The row that a line holds; raises InputError if it was damaged."""
    row = parse_object(line)
    check_sum(row, row.pop(_CHECK, None))
    return row


def append_rows(path: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Add rows to the file. Raises StorageError, and ValueError for NaN or infinity."""
    append(path, b"".join(map(row_line, rows)))


def read_rows(path: Path, most: int = MOST_ROWS) -> list[dict[str, Any]]:
    """All rows, at most `most`, in the order of the file; a last line cut short is no row.

    Raises InputError (without the file's name) for a damaged one, and StorageError.
    """
    rows = []
    for number, line in enumerate(_lines(path, most), start=1):
        if not line.endswith(b"\n"):
            break
        try:
            rows.append(parse_row(line))
        except InputError as error:
            raise InputError(f"line {number}: {error}") from None
    return rows


def drop_torn_end(path: Path) -> None:
    """Leave whole lines, so that the next row does not follow a half one. Raises StorageError, InputError."""
    lines = list(_lines(path, MOST_ROWS)) if present(path) else []
    if lines and not lines[-1].endswith(b"\n"):
        write_whole(path, lambda file: file.write(b"".join(lines[:-1])))


def cut_rows(path: Path, generations: Sequence[int], most: int = MOST_ROWS) -> None:
    """Leave the rows of the first `generations[i]` generations of instance i, and no others, of at most `most`.

    Raises InputError (without the file's name) if one of those is missing, damaged or there twice, and StorageError.
    """
    kept: dict[tuple[int, int], bytes] = {}
    dropped = False
    for line in _lines(path, most) if present(path) else ():
        try:  # beyond the last save nothing is certain to be whole, and nothing is kept
            place = _place(parse_row(line)) if line.endswith(b"\n") else None
        except InputError:
            place = None
        if place in kept:
            raise InputError(f"generation {place[0]} of instance {place[1]} is there twice")
        if place is not None and place[1] < len(generations) and place[0] < generations[place[1]]:
            kept[place] = line
        else:
            dropped = True
    for instance, count in enumerate(generations):
        for generation in range(count):
            if (generation, instance) not in kept:
                raise InputError(f"generation {generation} of instance {instance} is missing or damaged")
    if dropped:
        write_whole(path, lambda file: file.write(b"".join(kept.values())))


def sort_rows(path: Path, most: int = MOST_ROWS) -> None:
    """Put the rows, at most `most`, in order of generation and instance.

    Raises InputError (without the file's name), StorageError.
    """
    lines = [line for line in _lines(path, most) if line.endswith(b"\n")]
    ordered = sorted(lines, key=lambda line: _place(parse_row(line)))
    if ordered != lines:
        write_whole(path, lambda file: file.write(b"".join(ordered)))


def _lines(path: Path, most: int) -> Iterator[bytes]:
    """Lines with their ends; the last may have none. Raises InputError for more or longer ones, and StorageError."""
    with storing(path, "read"), reading(path, most * LONGEST_ROW) as file:
        yield from bounded_lines(file, most)


def bounded_lines(file: BinaryIO, most: int) -> Iterator[bytes]:
    """The lines that follow, with their ends; the last may have none. Raises InputError for more or longer ones."""
    count = 0
    while line := file.readline(LONGEST_ROW + 1):
        count += 1
        if count > most:
            raise InputError(f"more than {most:,} lines; accepted are as many as its run has generations of instances")
        if len(line) > LONGEST_ROW:
            raise InputError(f"line {count}: longer than {LONGEST_ROW} bytes")
        yield line


def _place(row: Mapping[str, Any]) -> tuple[int, int]:
    place = row.get("generation"), row.get("instance")
    if not all(isinstance(value, int) and not isinstance(value, bool) and value >= 0 for value in place):
        raise InputError("a row without generation or instance")
    return place  # type: ignore[return-value]
