"""The command that is being done, as a user would type it again: runs record it."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

_remembered: list[str] = []  # the last is the command under way; empty in a program that calls us from Python


def begin(arguments: Sequence[str]) -> None:
    """The console command was called with these arguments."""
    remember(shlex.join(["slcs2", *arguments]))


def remember(text: str) -> None:
    """This is the command, in a process that does a part of it for another one."""
    _remembered[:] = [text]


def end() -> None:
    """The console command has ended; what follows in this process is not its doing."""
    _remembered.clear()


def command() -> str:
    """A line for a shell: the console command, or else the program that calls us."""
    if _remembered:
        return _remembered[-1]
    return shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]) if sys.argv else ""
