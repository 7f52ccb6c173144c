"""Records kept small while nobody looks at them: of a member's numbers most are zero or alike."""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

_LENGTH = struct.Struct("<I")
_MOST = 64 * 1000 * 128  # bytes of all arrays: agents, rules, and a condition's words and figures


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
    left = _MOST
    for name, value in json.loads(data[_LENGTH.size : start]).items():
        if isinstance(value, dict):
            dtype, size = np.dtype(value["dtype"]), math.prod(value["shape"])
            raw = _unpacked(data[start : start + value["length"]], size * dtype.itemsize, left)
            left -= len(raw)
            values[name] = np.frombuffer(raw, dtype).reshape(value["shape"])
            start += value["length"]
        else:
            values[name] = tuple(value) if isinstance(value, list) else value
    return values


def _unpacked(data: bytes, size: int, most: int) -> bytearray:
    """So many bytes from compressed ones, and never more. Raises ValueError, zlib.error."""
    if not 0 <= size <= most:
        raise ValueError(f"an array of {size} bytes; accepted are at most {_MOST} in all")
    unpacking = zlib.decompressobj()
    raw = unpacking.decompress(data, size + 1)
    if len(raw) != size or not unpacking.eof:
        raise ValueError(f"an array is not {size} bytes long")
    return bytearray(raw)
