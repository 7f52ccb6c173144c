"""The command line of the benchmarks: what is wrong is said in one line, with exit code 2."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from slcs2_jax.config import InputError

CELLS = tuple(f"{kind}/{far}" for far in ("short", "long") for kind in ("open", "urban", "jammed", "urban_jammed"))


class _Help(argparse.ArgumentDefaultsHelpFormatter):
    """Shows defaults as they would be typed, where there are any."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        default = action.default
        if default is None or default is False or default is argparse.SUPPRESS:
            return action.help
        if isinstance(default, tuple):
            return f"{action.help} (default: {','.join(map(str, default))})"
        return super()._get_help_string(action)


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaints are one line; the name of the module is the program."""

    def __init__(self, module: str, description: str) -> None:
        super().__init__(
            prog=f"python -m benchmarks.{module}",
            description=description,
            formatter_class=_Help,
            allow_abbrev=False,
        )
        self.add_argument("--json", type=Path, metavar="PATH", help="write the figures there as well")

    def error(self, message: str) -> NoReturn:
        """End with code 2."""
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())}\n")

    def check_folders(self, *paths: Path | None) -> None:
        """Refuse, before anything is measured, files that could not be written."""
        for path in paths:
            if path is not None and (path.is_dir() or not path.absolute().parent.is_dir()):
                self.error(f"{path}: cannot be written; accepted is the path of a file in a folder that exists")

    def run(self, measure: Callable[[argparse.Namespace], None], arguments: list[str] | None) -> int:
        """Parse and measure; bad input found on the way ends likewise."""
        options = self.parse_args(arguments)
        options.command = shlex.join([*self.prog.split(), *(sys.argv[1:] if arguments is None else arguments)])
        try:
            measure(options)
        except InputError as error:
            self.error(str(error))
        return 0


def whole(low: int, high: int) -> Callable[[str], int]:
    """A whole number within limits."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdigit() and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{text!r}: accepted is a whole number from {low} to {high}")
        return int(text)

    return parse


def listed(one: Callable[[str], Any]) -> Callable[[str], tuple[Any, ...]]:
    """Different values with commas between them."""

    def parse(text: str) -> tuple[Any, ...]:
        values = tuple(map(one, text.split(",")))
        if len(set(values)) < len(values):
            raise argparse.ArgumentTypeError(f"{text!r}: names a value twice")
        return values

    return parse


def choice(*names: str) -> Callable[[str], str]:
    """One of some names."""

    def parse(text: str) -> str:
        if text not in names:
            raise argparse.ArgumentTypeError(f"{text!r}: accepted are {', '.join(names)}")
        return text

    return parse
