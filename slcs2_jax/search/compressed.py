"""Records kept small while nobody looks at them: of a member's numbers most are zero or alike."""

from __future__ import annotations

import json
import math
import struct
import zlib
from dataclasses import fields
from typing import Any, Generic, TypeVar

import numpy as np

Record = TypeVar("Record")

_LENGTH = struct.Struct("<I")
_MOST = 64 * 1000 * 16  # bytes of an array: agents, rules, and a condition's words


class Compressed(Generic[Record]):
    """A dataclass instance of arrays, numbers and tuples of numbers as one string of bytes, without loss.

    The bytes are a head (JSON: a value for each field, and for an array its type, shape and length), with its length
    before it, and the arrays behind it, each compressed. They can be stored as they are.
    """

    def __init__(self, record: Record) -> None:
        self._kind = type(record)
        head: dict[str, Any] = {}
        arrays = []
        for field in fields(record):  # type: ignore[arg-type]
            value = getattr(record, field.name)
            if isinstance(value, np.ndarray):
                arrays.append(zlib.compress(np.ascontiguousarray(value).data, 1))
                value = {"dtype": value.dtype.str, "shape": value.shape, "length": len(arrays[-1])}
            head[field.name] = value
        text = json.dumps(head).encode()
        self.data = b"".join([_LENGTH.pack(len(text)), text, *arrays])

    @classmethod
    def of_data(cls, kind: type[Record], data: bytes) -> Compressed[Record]:
        """The one whose `data` this was. Raises ValueError, KeyError, TypeError or zlib.error if it was none's."""
        made = cls.__new__(cls)
        made._kind, made.data = kind, data
        made.record()  # what cannot be unpacked is found out now
        return made

    def record(self) -> Record:
        """An instance with the same values."""
        start = _LENGTH.size
        (length,) = _LENGTH.unpack_from(self.data)
        head, start = json.loads(self.data[start : start + length]), start + length
        for name, value in head.items():
            if isinstance(value, dict):
                dtype, size = np.dtype(value["dtype"]), math.prod(value["shape"])
                raw = _unpacked(self.data[start : start + value["length"]], size * dtype.itemsize)
                head[name] = np.frombuffer(raw, dtype).reshape(value["shape"])
                start += value["length"]
            elif isinstance(value, list):
                head[name] = tuple(value)
        return self._kind(**head)


def _unpacked(data: bytes, size: int) -> bytearray:
    """So many bytes from compressed ones, and never more. Raises ValueError, zlib.error."""
    if not 0 <= size <= _MOST:
        raise ValueError(f"an array of {size} bytes; accepted are at most {_MOST}")
    unpacking = zlib.decompressobj()
    raw = unpacking.decompress(data, size + 1)
    if len(raw) != size or not unpacking.eof:
        raise ValueError(f"an array is not {size} bytes long")
    return bytearray(raw)
