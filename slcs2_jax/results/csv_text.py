"""Rows as comma-separated text."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from slcs2_jax.config import escape


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A header and rows; what is not known (None) is empty.

    A text that a spreadsheet would compute has an apostrophe before it (see `escape.csv_cell`).
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([escape.csv_cell(name) for name in header])
    for row in rows:
        texts = [escape.csv_cell(value) if isinstance(value, str) else value for value in row]
        writer.writerow(["" if value is None else value for value in texts])
    return text.getvalue()
