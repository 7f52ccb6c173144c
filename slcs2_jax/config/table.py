"""The settings as tables: for the documentation and for --help. All come from the dataclass fields."""

from __future__ import annotations

from typing import NamedTuple

from slcs2_jax.config.errors import show
from slcs2_jax.config.field import STATUS_MEANING, accepted
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.config.settings import SECTIONS, Settings


class Row(NamedTuple):
    """One setting; `name` is what a user types, `status` one of STATUS_MEANING, `section` "" for a run's own."""

    name: str
    value: str
    unit: str
    status: str
    reason: str
    help: str
    accepted: str
    section: str
    names: tuple[str, ...]


def settings_table() -> list[Row]:
    """One row per setting, in the order of the sections; what names a part accepts what is registered now."""
    return [
        Row(
            name=field.name,
            value=show(field.default),
            unit=doc.unit,
            status=doc.status,
            reason=doc.reason,
            help=doc.help,
            accepted=accepted(field),
            section=section,
            names=doc.names,
        )
        for section, field in settings_fields()
        for doc in (field.doc,)
    ]


def reference_markdown() -> str:
    """The reference page: every setting with default, unit, what is accepted, status, meaning and reason."""
    lines = [
        "# Settings",
        "",
        "Every setting is typed as `name=value`, and read from Python as an attribute: `radio.noise_dbm` is "
        "`settings.radio.noise_dbm`. This page is made from the dataclasses in `slcs2_jax/config/` by "
        "`slcs2_jax.config.table.reference_markdown`.",
        "",
        *(f"- *{status}*: {meaning}" for status, meaning in STATUS_MEANING.items()),
    ]
    rows = settings_table()
    for section, kind in {**SECTIONS, "": Settings}.items():
        lines += ["", f"## {section or 'of a run'}", "", (kind.__doc__ or "").split("\n")[0], ""]
        lines += [
            "| setting | default | unit | accepted | status | meaning | reason |",
            "|---|---|---|---|---|---|---|",
        ]
        lines += [
            f"| `{row.name}` | `{row.value}` | {row.unit or '–'} | {_cell(row.accepted)} | {row.status} | "
            f"{_cell(row.help)} | {_cell(row.reason) or '–'} |"
            for row in rows
            if row.section == section
        ]
    return "\n".join(lines) + "\n"


def settings_help() -> str:
    """The table of all settings for a terminal."""
    rows = settings_table()
    width = max(len(row.name) + 1 + len(row.value) for row in rows)
    units = max(len(row.unit) for row in rows)
    lines = [
        f"  {f'{row.name}={row.value}':{width}}  {row.unit:{units}}  {row.status:10}  {_said(row)}" for row in rows
    ]
    meanings = [f"  {status:10}  {meaning}" for status, meaning in STATUS_MEANING.items()]
    return "\n".join(["Settings, with default, unit, status and meaning:", *lines, "", "Status:", *meanings]) + "\n"


def _said(row: Row) -> str:
    return f"{row.help} ({', '.join(row.names)})" if row.names else row.help


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
