"""JSON documents that say which format they have and carry a checksum, so that no damaged one is believed.

A format is `slcs2_jax KIND VERSION`; the checksum is the CRC-32 of everything else, written canonically.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slcs2_jax.config.door import read_file
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import show
from slcs2_jax.results.files import write_json

_PREFIX = "slcs2_jax"
_CANONICAL = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False)
_SPARSE = 12  # bytes, at least, to a list or a mapping of a document: each takes as many as a hundred of memory


def checksum(value: Any) -> str:
    """CRC-32 (hex) of a JSON-able value; raises ValueError for NaN or infinity."""
    text = _CANONICAL.encode(value)
    return f"{zlib.crc32(text.encode('utf-8', 'surrogatepass')):08x}"


def check_format(found: object, accepted: str) -> None:
    """Raise InputError unless `found` is the accepted format, saying what else it is: foreign, older or newer."""
    if found == accepted:
        return
    kind, _, version = accepted.rpartition(" ")
    said = found.rpartition(" ") if isinstance(found, str) else ("", "", "")
    if said[0] == kind and said[2].isascii() and said[2].isdigit() and len(said[2]) < 9:
        newer = int(said[2]) > int(version)
        age, advice = ("a newer", "update slcs2_jax") if newer else ("an older", "use the older one")
        raise InputError(f"version {said[2]} of {age} slcs2_jax; accepted is version {version}: {advice}")
    raise InputError(f"format {show(found)}; accepted is {accepted!r}")


def write_document(
    path: Path, kind: str, version: int, content: Mapping[str, Any], *, inside: Path | None = None
) -> None:
    """Write a document, whole or not at all. Raises StorageError, and ValueError for NaN or infinity."""
    document = {"format": f"{_PREFIX} {kind} {version}", **content}
    write_json(path, document | {"checksum": checksum(document)}, inside=inside)


def read_document(path: Path, kind: str, version: int, most: int = 2**20) -> dict[str, Any]:
    """The content of a document of at most `most` bytes.

    Raises InputError (without the file's name) if it is none, larger or damaged, and OSError.
    """
    value = parse_object(read_file(path, most))
    check_format(value.pop("format", None), f"{_PREFIX} {kind} {version}")
    said = value.pop("checksum", None)
    check_sum({"format": f"{_PREFIX} {kind} {version}", **value}, said)
    return value


def check_sum(value: Any, said: object) -> None:
    """Raise InputError unless the checksum of a value that was read is the one that its file says."""
    try:
        fits = said == checksum(value)
    except (ValueError, RecursionError) as error:  # a number too large for a float is infinite, and has none
        raise InputError(f"no JSON of slcs2: {show(str(error))}") from None
    if not fits:
        raise InputError("its checksum does not fit: it was damaged or changed by hand")


def _refuse(name: str) -> None:
    raise ValueError(f"{name} is no finite number")


def _once_each(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Two rows run into one have every name twice, and a checksum that fits the second."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name is there twice")
    return found


_DECODER = json.JSONDecoder(parse_constant=_refuse, object_pairs_hook=_once_each)


def parse_object(data: bytes) -> dict[str, Any]:
    """A JSON object of finite numbers from UTF-8 bytes; raises InputError."""
    if data.count(b"[") + data.count(b"{") > 64 + len(data) // _SPARSE:
        raise InputError("no JSON of slcs2: more lists and mappings than any document has")
    try:
        value = _DECODER.decode(data.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"no JSON, or cut short: {show(str(error))}") from None
    if not isinstance(value, dict):
        raise InputError("a JSON object is expected")
    return value
