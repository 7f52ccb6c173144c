"""YAML from files, read without believing it: no aliases, bounded in length, depth and numbers; no Python objects."""

from __future__ import annotations

import re
from typing import Any

from slcs2_jax.config.errors import InputError, show

MOST_BYTES = 2**20
_DIGITS = re.compile(r"[-+0-9a-fA-FxoXO_.:]{200,}\Z")  # base 60 takes the square of the time


def parse_yaml(data: bytes | str, *, deepest: int = 24) -> Any:
    """The value of a YAML text of at most 1 MiB, nested at most so deep.

    Raises InputError of one line (without the file's name).
    """
    import yaml

    if len(data) > MOST_BYTES:
        raise InputError(f"{len(data):,} bytes of YAML; accepted are at most {MOST_BYTES:,}")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        _check(yaml, yaml.parse(data, loader), deepest)
        return yaml.load(data, loader)
    except InputError:
        raise
    except Exception as error:  # of odd texts its constructors raise almost anything
        raise InputError(f"no YAML, or cut short: {show(str(error))}") from None


def _check(yaml: Any, events: Any, deepest: int) -> None:
    depth = 0
    for event in events:
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
            raise InputError(f"line {event.start_mark.line + 1}: an anchor or an alias; accepted is YAML without them")
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > deepest:
                raise InputError(f"line {event.start_mark.line + 1}: nested deeper than {deepest}")
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.ScalarEvent) and _DIGITS.match(event.value):
            raise InputError(f"line {event.start_mark.line + 1}: a number of {len(event.value)} letters")
