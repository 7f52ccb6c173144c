"""What tests of several rooms build: parts of users' own, registered for as long as a test needs them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from slcs2_jax.config.registry import KINDS


@contextmanager
def registered(parts: dict[str, dict[str, Any]], home: str = "tests.builders") -> Iterator[None]:
    """Parts by kind and name, forgotten again behind the block."""
    for kind, named in parts.items():
        for name, part in named.items():
            KINDS[kind].add(name, part, home)
    try:
        yield
    finally:
        for kind, named in parts.items():
            for name in named:
                KINDS[kind].forget(name)
