"""Checks of what functions are given from Python, in the words that settings are refused with."""

from __future__ import annotations

import numbers
import os
from pathlib import Path
from typing import TypeVar

from slcs2_jax.config.errors import refuse

Kind = TypeVar("Kind")


def whole(name: str, value: object, low: int, high: int) -> int:
    """The value as an int from `low` to `high`; raises InputError otherwise."""
    if isinstance(value, numbers.Integral) and not isinstance(value, bool) and low <= int(value) <= high:
        return int(value)
    raise refuse(name, value, f"a whole number from {low} to {high}")


def of_kind(name: str, value: object, kind: type[Kind]) -> Kind:
    """The value if it is of this class; raises InputError otherwise."""
    if not isinstance(value, kind):
        raise refuse(name, type(value).__name__, f"a {kind.__name__}")
    return value


def path_of(name: str, value: object) -> Path:
    """The value as a Path; raises InputError if it is none."""
    if not isinstance(value, str | os.PathLike) or "\0" in str(value):
        raise refuse(name, value, "the path of a file or folder")
    return Path(value)
