"""One configuration field: its documentation and its limits stand beside its default; the check reads them there."""

from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Iterator
from dataclasses import dataclass
from types import UnionType
from typing import Any, ClassVar, Literal, Union, get_args, get_origin, get_type_hints

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal

LEAST = 1e-4  # of what must be above 0: less than this is nothing beside the rest in float32, or even its square is 0
Status = Literal["paper", "assumed", "calibrated", "definition", "run"]

STATUS_MEANING: dict[Status, str] = {
    "paper": "printed in the paper",
    "assumed": "stands in for an unpublished appendix",
    "calibrated": "assumed, and chosen so that results reach the paper's magnitude",
    "definition": "follows from the project's reading of the paper or names a choice",
    "run": "how this run is made; no part of the model",
}

_TRUE = frozenset({"true", "on", "yes"})
_FALSE = frozenset({"false", "off", "no"})


@dataclass(frozen=True, kw_only=True)
class Doc:
    """What is said about a field, and what it accepts.

    `low`/`high` are inclusive bounds, the upper one unless `high_open`; of a tuple's numbers, which are `distinct` or
    not, and `fewest` to `most` in number. `options` lists the accepted strings; `part` is the kind of part (see
    `registry`) whose names are accepted instead. `name` is what a user types if it differs from section.field;
    `reason` says where the value comes from.
    """

    help: str
    unit: str = ""
    status: Status = "assumed"
    reason: str = ""
    low: float | None = None
    high: float | None = None
    high_open: bool = False
    fewest: int = 0
    most: int = 0
    distinct: bool = False
    options: tuple[str, ...] = ()
    part: str = ""
    name: str | None = None

    def choices(self) -> tuple[str, ...]:
        """The accepted strings; () if any is."""
        if not self.part:
            return self.options
        from slcs2_jax.config.registry import KINDS  # which refuses names in the words of this module

        return KINDS[self.part].names()


def setting(default: Any, help: str, **doc: Any) -> Any:
    """A dataclass field with its documentation; keywords as in `Doc`."""
    return dataclasses.field(default=default, metadata={"doc": Doc(help=help, **doc)})


@dataclass(frozen=True)
class Described:
    """A field of a section together with the name a user types, its type and its documentation.

    kind: bool, int, float, str, or tuple for a tuple of whole numbers.
    """

    attribute: str
    name: str
    kind: type
    optional: bool
    default: Any
    doc: Doc


def described(section: type) -> Iterator[Described]:
    """The documented fields of a section class, in order; fields without documentation (sub-sections) are left out."""
    hints = get_type_hints(section)
    prefix = getattr(section, "SECTION", "")
    for field in dataclasses.fields(section):
        doc = field.metadata.get("doc")
        if doc is None:
            continue
        kind, optional = _kind(hints[field.name])
        name = doc.name or (f"{prefix}.{field.name}" if prefix else field.name)
        yield Described(field.name, name, kind, optional, field.default, doc)


def _kind(hint: Any) -> tuple[type, bool]:
    """The type that a field's annotation stands for, and whether it may be None."""
    optional = get_origin(hint) in (Union, UnionType)
    if optional:
        hint = next(kind for kind in get_args(hint) if kind is not type(None))
    return get_origin(hint) or hint, optional


def show(value: object) -> str:
    """A value as a user would type it, on one line, printable and never long."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        value = "[" + ",".join(map(show, value)) + "]"
    text = str(value) if isinstance(value, str | int | float) else repr(value)
    text = terminal(" ".join(text.split()))
    return text if len(text) <= 80 else text[:77] + "..."


def accepted(field: Described) -> str:
    """In words, what the field accepts."""
    doc = field.doc
    if choices := doc.choices():
        words = "one of " + ", ".join(choices) + (", or a name that plugins= brings" if doc.part else "")
    elif field.kind is tuple:
        words = f"a list of {doc.fewest} to {doc.most}{' different' * doc.distinct} whole numbers{_bounds(doc)}"
    elif field.kind is bool:
        words = "true or false"
    elif field.kind is str:
        words = "a text"
    else:
        words = ("a whole number" if field.kind is int else "a finite number") + _bounds(doc)
    return words + (" or null" if field.optional else "")


def _bounds(doc: Doc) -> str:
    low = None if doc.low is None else f">= {doc.low:.12g}"
    high = None if doc.high is None else f"{'<' if doc.high_open else '<='} {doc.high:.12g}"
    if doc.low is not None and doc.high is not None and not doc.high_open:
        return f" from {doc.low:.12g} to {doc.high:.12g}"
    parts = [part for part in (low, high) if part]
    return " " + " and ".join(parts) if parts else ""


def refuse(name: str, value: object, accepts: str) -> InputError:
    """The error for one field, in the one form all of them have."""
    return InputError(f"{name}={show(value)}: accepted is {accepts}")


def check(field: Described, value: object) -> Any:
    """The value in the field's own type; raises InputError on a wrong type, a non-finite or an out-of-bounds value."""
    if value is None and field.optional:
        return None
    try:
        converted = _convert(field.kind, value)
    except (TypeError, ValueError, OverflowError):
        raise refuse(field.name, value, accepted(field)) from None
    doc = field.doc
    choices = doc.choices()
    if choices and converted not in choices:
        raise refuse(field.name, value, accepted(field))
    if field.kind is tuple:
        few = len(converted) < doc.fewest or (doc.distinct and len(set(converted)) < len(converted))
        if few or len(converted) > doc.most or not all(_within(doc, number) for number in converted):
            raise refuse(field.name, value, accepted(field))
    if field.kind in (int, float) and not _within(doc, converted):
        raise refuse(field.name, value, accepted(field))
    return converted


def _within(doc: Doc, number: float) -> bool:
    too_low = doc.low is not None and number < doc.low
    too_high = doc.high is not None and (number >= doc.high if doc.high_open else number > doc.high)
    return not (too_low or too_high)


def _convert(kind: type, value: object) -> Any:
    if kind is bool:
        if isinstance(value, bool):
            return value
        word = str(value).lower() if isinstance(value, str) else ""
        if word in _TRUE | _FALSE:
            return word in _TRUE
        raise TypeError
    if kind is str:
        if isinstance(value, str) and value.strip():
            return value
        raise TypeError
    if kind is tuple:
        if isinstance(value, list | tuple):
            return tuple(_convert(int, number) for number in value)
        raise TypeError
    if isinstance(value, bool):
        raise TypeError
    if kind is int:
        if isinstance(value, numbers.Integral):
            return int(value)
        raise TypeError
    if not isinstance(value, numbers.Real):
        raise TypeError
    number = float(value)
    if not math.isfinite(number):
        raise ValueError
    return number


class Section:
    """Base of the frozen configuration dataclasses: every documented field is checked when one is made."""

    SECTION: ClassVar[str] = ""

    def __post_init__(self) -> None:
        for field in described(type(self)):
            object.__setattr__(self, field.attribute, check(field, getattr(self, field.attribute)))
        self.cross_check()

    def cross_check(self) -> None:
        """What must hold between fields; raises InputError."""
