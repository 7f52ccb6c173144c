"""Records kept small while nobody looks at them: of a member's numbers most are zero or alike."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

_LENGTH = struct.Struct("<I")


def compress(values: Mapping[str, Any]) -> bytes:
    """Arrays, numbers and tuples of numbers by name as one string of bytes, without loss.

    The bytes are a head (JSON: a value for each name, and for an array its type, shape and length), with its length
    before it, and the arrays behind it, each compressed. They can be stored as they are.
    """
    head: dict[str, Any] = {}
    arrays = []
    for name, value in values.items():
        if isinstance(value, np.ndarray):
            arrays.append(zlib.compress(np.ascontiguousarray(value).data, 1))
            value = {"dtype": value.dtype.str, "shape": value.shape, "length": len(arrays[-1])}
        head[name] = value
    text = json.dumps(head).encode()
    return b"".join([_LENGTH.pack(len(text)), text, *arrays])


def decompress(data: bytes) -> dict[str, Any]:
    """What `compress` was given. Raises ValueError, KeyError, TypeError, AttributeError, struct.error or zlib.error for
    other bytes."""
    (length,) = _LENGTH.unpack_from(data)
    start = _LENGTH.size + length
    values: dict[str, Any] = {}
    for name, value in json.loads(data[_LENGTH.size : start]).items():
        if isinstance(value, dict):
            raw = bytearray(zlib.decompress(data[start : start + value["length"]]))
            values[name] = np.frombuffer(raw, np.dtype(value["dtype"])).reshape(value["shape"])
            start += value["length"]
        else:
            values[name] = tuple(value) if isinstance(value, list) else value
    return values
