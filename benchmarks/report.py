"""What a benchmark prints, and the same figures as JSON."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks import machine
from slcs2_jax.config import Compute
from slcs2_jax.results.files import write_json

Row = Mapping[str, Any]


class Report:
    """Figures of one run of a benchmark: rows by the name of their table."""

    def __init__(self, name: str, command: str, compute: Compute, notes: str) -> None:
        """``notes`` are what a reader must know of how the figures were made. Starts JAX."""
        self.about: dict[str, Any] = {
            "benchmark": name,
            "command": command,
            "machine": machine.describe(compute),
            "notes": " ".join(notes.split()),
        }
        self.tables: dict[str, list[dict[str, Any]]] = {}

    def heading(self) -> str:
        """The command and the machine, for the top of the output."""
        return f"`{self.about['command']}`\n\n{machine.in_words(self.about['machine'])}\n"

    def notes(self) -> str:
        """For the bottom of the output."""
        return textwrap.fill(self.about["notes"], 120)

    def add(self, table: str, rows: Sequence[Row]) -> None:
        """Keep rows of a table."""
        self.tables.setdefault(table, []).extend(dict(row) for row in rows)

    def save(self, path: Path | None) -> None:
        """Write everything, whole or not at all; None writes nothing."""
        if path is not None:
            write_json(path, {**self.about, "tables": self.tables})


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; the first column to the left, figures to the right."""
    lines = [header, ["---", *["--:"] * (len(header) - 1)], *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def figure(value: float | None, digits: int = 3) -> str:
    """A number with so many significant digits, in thousands; a dash for none."""
    if value is None:
        return "–"
    if value == 0:
        return "0"
    size = len(str(int(abs(value)))) if abs(value) >= 1 else 0
    rounded = round(value, digits - size) if size else float(f"{value:.{digits}g}")
    return f"{rounded:,.0f}" if size >= digits else f"{rounded:,.{digits - size}f}" if size else f"{rounded:g}"
