"""One configuration field: its documentation and its limits stand beside its default; the check reads them there."""

from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args, get_origin, get_type_hints

from slcs2_jax.config.errors import refuse, show
from slcs2_jax.config.registry import KINDS, may_be_named

__all__ = [
    "STATUS_MEANING",
    "Described",
    "Doc",
    "Section",
    "accepted",
    "check",
    "described",
    "refuse",
    "setting",
    "show",
]

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

    `low`/`high` are inclusive bounds, the upper one unless `high_open`; `options` lists the accepted strings; `part` is
    the kind of part that the value names (`registry.KINDS`), whose names are then accepted; `fewest`/`most` bound the
    length of a list, whose entries differ if `distinct`; `name` is what a user types if it differs from section.field;
    `reason` says where the value comes from.
    """

    help: str
    unit: str = ""
    status: Status = "assumed"
    reason: str = ""
    low: float | None = None
    high: float | None = None
    high_open: bool = False
    options: tuple[str, ...] = ()
    part: str = ""
    fewest: int = 0
    most: int | None = None
    distinct: bool = False
    name: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The accepted strings: the options, or the names of the parts that are registered now; () if any will do."""
        return KINDS[self.part].names() if self.part else self.options


def setting(default: Any, help: str, **doc: Any) -> Any:
    """A dataclass field with its documentation; keywords as in `Doc`."""
    return dataclasses.field(default=default, metadata={"doc": Doc(help=help, **doc)})


@dataclass(frozen=True)
class Described:
    """A field of a section together with the name a user types, its type and its documentation.

    `kind` is the type of the value or, where it `is_list`, of each entry of what is held as a tuple.
    """

    attribute: str
    name: str
    kind: type
    is_list: bool
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
        name = doc.name or (f"{prefix}.{field.name}" if prefix else field.name)
        yield Described(field.name, name, *_kind_of(hints[field.name]), field.default, doc)


def _kind_of(hint: Any) -> tuple[type, bool, bool]:
    """Type of a value or an entry, is it a list of them, may it be null: of `int`, `int | None`, `tuple[int, ...]`."""
    if get_origin(hint) is tuple:
        return get_args(hint)[0], True, False
    options = [kind for kind in get_args(hint) if kind is not type(None)]
    return (options[0], False, True) if options else (hint, False, False)


def accepted(field: Described) -> str:
    """In words, what the field accepts."""
    doc = field.doc
    if field.is_list:
        entries = {int: "whole numbers", float: "finite numbers", str: "texts"}[field.kind]
        if doc.names:
            entries = "some of " + ", ".join(doc.names)
        return f"a list of {_count(doc)}{'different ' if doc.distinct else ''}{entries}{_bounds(doc)}"
    if doc.names:
        words = "one of " + ", ".join(doc.names)
    elif field.kind is bool:
        words = "true or false"
    elif field.kind is str:
        words = "a text"
    else:
        words = ("a whole number" if field.kind is int else "a finite number") + _bounds(doc)
    return words + (" or null" if field.optional else "") + (", or a name that plugins= brings" if doc.part else "")


def _count(doc: Doc) -> str:
    if doc.most is not None:
        return f"{doc.fewest} to {doc.most} "
    return f"at least {doc.fewest} " if doc.fewest else ""


def _bounds(doc: Doc) -> str:
    low = None if doc.low is None else f">= {doc.low:.12g}"
    high = None if doc.high is None else f"{'<' if doc.high_open else '<='} {doc.high:.12g}"
    if doc.low is not None and doc.high is not None and not doc.high_open:
        return f" from {doc.low:.12g} to {doc.high:.12g}"
    parts = [part for part in (low, high) if part]
    return " " + " and ".join(parts) if parts else ""


def check(field: Described, value: object) -> Any:
    """The value in the field's own type; raises InputError on a wrong type, a non-finite or an out-of-bounds value."""
    if value is None and field.optional:
        return None
    try:
        if not field.is_list:
            return _checked(field, value)
        entries = [value] if field.kind is str and isinstance(value, str) else value
        if not isinstance(entries, list | tuple):
            raise TypeError
        found = tuple(_checked(field, entry) for entry in entries)
        too_long = field.doc.most is not None and len(found) > field.doc.most
        if len(found) < field.doc.fewest or too_long or (field.doc.distinct and len(set(found)) < len(found)):
            raise ValueError
        return found
    except (TypeError, ValueError, OverflowError):
        raise refuse(field.name, value, accepted(field)) from None


def _checked(field: Described, value: object) -> Any:
    """One value in the field's type; raises TypeError, ValueError or OverflowError."""
    converted = _convert(field.kind, value)
    doc = field.doc
    if not may_be_named(doc.part, converted) if doc.part else doc.names and converted not in doc.names:
        raise ValueError
    if field.kind in (int, float):
        too_low = doc.low is not None and converted < doc.low
        too_high = doc.high is not None and (converted >= doc.high if doc.high_open else converted > doc.high)
        if too_low or too_high:
            raise ValueError
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
