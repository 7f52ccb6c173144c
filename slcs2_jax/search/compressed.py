"""Records kept small while nobody looks at them: of a member's numbers most are zero or alike."""

from __future__ import annotations

import json
import struct
import zlib
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, Generic, TypeVar, get_type_hints

import numpy as np

Record = TypeVar("Record")

_LENGTH = struct.Struct("<I")


class Compressed(Generic[Record]):
    """A dataclass instance of arrays, numbers, tuples of numbers and such records as one string of bytes, without loss.

    The bytes are a head (JSON: a value for each field, and for an array its type, shape and length), with its length
    before it, and the arrays behind it, each compressed. They can be stored as they are.
    """

    def __init__(self, record: Record) -> None:
        self._kind = type(record)
        arrays: list[bytes] = []
        text = json.dumps(_head(record, arrays)).encode()
        self.data = b"".join([_LENGTH.pack(len(text)), text, *arrays])

    @classmethod
    def of_data(cls, kind: type[Record], data: bytes) -> Compressed[Record]:
        """The one whose `data` this was. Raises ValueError, KeyError, TypeError, AttributeError or zlib.error for
        other bytes."""
        made = cls.__new__(cls)
        made._kind, made.data = kind, data
        made.record()  # what cannot be unpacked is found out now
        return made

    def record(self) -> Record:
        """An instance with the same values."""
        (length,) = _LENGTH.unpack_from(self.data)
        body = _LENGTH.size + length
        record, _ = _record(self._kind, json.loads(self.data[_LENGTH.size : body]), self.data, body)
        return record


def _head(record: Any, arrays: list[bytes]) -> dict[str, Any]:
    """What the head says of a record; its arrays are appended to those given."""
    head: dict[str, Any] = {}
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, np.ndarray):
            arrays.append(zlib.compress(np.ascontiguousarray(value).data, 1))
            value = {"dtype": value.dtype.str, "shape": value.shape, "length": len(arrays[-1])}
        elif is_dataclass(value):
            value = _head(value, arrays)
        head[field.name] = value
    return head


def _record(kind: Any, head: dict[str, Any], data: bytes, start: int) -> tuple[Any, int]:
    """The record that a head describes, and where its arrays, which begin at `start`, end."""
    values = dict(head)
    inner = _records_in(kind)
    for name, value in head.items():
        if name in inner:
            values[name], start = _record(inner[name], value, data, start)
        elif isinstance(value, dict):
            raw = bytearray(zlib.decompress(data[start : start + value["length"]]))
            values[name] = np.frombuffer(raw, np.dtype(value["dtype"])).reshape(value["shape"])
            start += value["length"]
        elif isinstance(value, list):
            values[name] = tuple(value)
    return kind(**values), start


@cache
def _records_in(kind: type) -> dict[str, type]:
    """The fields of a dataclass that are dataclasses themselves."""
    return {name: hint for name, hint in get_type_hints(kind).items() if is_dataclass(hint) and isinstance(hint, type)}
