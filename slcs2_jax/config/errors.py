"""What the project raises when something it was given cannot be used, or cannot be stored; and how it says so."""

from __future__ import annotations

from slcs2_jax.config.escape import terminal


class InputError(ValueError):
    """Bad input from a person: the message is one line naming the field, its value and what is accepted."""


class StorageError(OSError):
    """A file could not be written or read, through no fault of what was asked: one line naming it and what to do."""


def show(value: object) -> str:
    """A value as a user would type it, on one line, printable and never long."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        text = "[" + ",".join(show(entry) for entry in value) + "]"
    else:
        try:
            text = str(value) if isinstance(value, str | int | float) else repr(value)
        except (ValueError, RecursionError):  # a number of thousands of digits, a list in itself
            text = "(too long to be shown)"
    text = terminal(" ".join(text.split()))
    return text if len(text) <= 80 else text[:77] + "..."


def refuse(name: str, value: object, accepts: str) -> InputError:
    """The error for one setting, in the one form all of them have."""
    return InputError(f"{name}={show(value)}: accepted is {accepts}")
