"""Text that a user wrote: read whole, or refused in one line."""

from __future__ import annotations

import os
from pathlib import Path

from slcs2_jax.config.door import present, read_file
from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.vocabulary import quote

MAX_BYTES = 64 * 1024


def read_source(kind: str, path: str | os.PathLike[str], known: str) -> str:
    """The text of a file of at most 64 KiB.

    kind: what it is, `grammar`, for messages. known: what is accepted instead. Raises InputError of one line if there
    is no such file or it is no such text.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise InputError(f"{kind}: {quote(path)} is no name; {known}")
    label = f"{kind} {quote(path, 120)}"
    try:
        file = Path(path)
        if not present(file):
            raise InputError(f"there is no such {kind} or file")
        data = read_file(file, MAX_BYTES)
    except InputError as error:
        raise InputError(f"{label}: {error}; {known}") from None
    except (OSError, ValueError, TypeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{label}: cannot be read ({quote(reason)}); {known}") from None
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{label}: not UTF-8 text (byte {error.start})") from None
