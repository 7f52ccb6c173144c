"""The settings as a table, for the README and for --help."""

from __future__ import annotations

from typing import NamedTuple

from slcs2_jax.config.field import STATUS_MEANING, accepted, show
from slcs2_jax.config.schema import settings_fields


class Row(NamedTuple):
    """One setting; `name` is what a user types, `status` one of STATUS_MEANING."""

    name: str
    value: str
    unit: str
    status: str
    reason: str
    help: str
    accepted: str


def settings_table() -> list[Row]:
    """One row per setting, in the order of the sections."""
    return [
        Row(field.name, show(field.default), doc.unit, doc.status, doc.reason, doc.help, accepted(field))
        for _, field in settings_fields()
        for doc in (field.doc,)
    ]


def settings_markdown() -> str:
    """The table of all settings of the model, with status and reason, in Markdown (runs' own settings left out)."""
    lines = ["| setting | value | unit | status | what it is; why this value |", "|---|---|---|---|---|"]
    for row in settings_table():
        if row.status != "run":
            text = f"{row.help}; {row.reason}" if row.reason else row.help
            lines.append(f"| `{row.name}` | {row.value} | {row.unit or '–'} | {row.status} | {text} |")
    return "\n".join(lines) + "\n"


def settings_help() -> str:
    """The table of all settings for a terminal."""
    rows = settings_table()
    width = max(len(row.name) + 1 + len(row.value) for row in rows)
    units = max(len(row.unit) for row in rows)
    lines = [f"  {f'{row.name}={row.value}':{width}}  {row.unit:{units}}  {row.status:10}  {row.help}" for row in rows]
    meanings = [f"  {status:10}  {meaning}" for status, meaning in STATUS_MEANING.items()]
    return "\n".join(["Settings, with default, unit, status and meaning:", *lines, "", "Status:", *meanings]) + "\n"
