"""The page on a run or several: one HTML file that needs no network, with data, program and style in it."""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import Any

from slcs2_jax import __version__
from slcs2_jax.config import InputError
from slcs2_jax.config.door import reading
from slcs2_jax.looking.page_data import Shown, figures, history, rule_table, run_facts
from slcs2_jax.looking.page_replay import pack_replay
from slcs2_jax.results.files import storing, write_text

PAGE = "report.html"
MARK = '<meta name="generator" content="slcs2_jax report">'  # by which an earlier page is known as ours

_LARGEST = 2**40  # bytes of an earlier page; its head alone is read
_PROGRAM = ("chart.js", "curves.js", "rules.js", "scene.js", "replay.js", "page.js")
_PLACE = re.compile(r"@@(\w+)@@")


def write_page(path: Path, title: str, shown: Iterable[Shown]) -> None:
    """Write the page whole. Raises StorageError."""
    write_text(path, page(title, shown))


def is_page(path: Path) -> bool:
    """Is this a file with a page that was made here? Raises StorageError."""
    try:
        with storing(path, "read"), reading(path, _LARGEST) as file:
            return MARK.encode() in file.read(1000)
    except InputError:  # a link, a folder, a device
        return False


def page(title: str, shown: Iterable[Shown]) -> str:
    """The HTML. Of each instance in `shown`, which is gone through once, nothing is kept but what the page holds."""
    blocks: list[str] = []

    def block(data: bytes) -> str:
        """Data that the program finds by a name. Base64 holds no `<`: nothing in it can end the element."""
        name = f"data-{len(blocks)}"
        text = base64.b64encode(data).decode("ascii")
        blocks.append(f'<script type="application/octet-stream;base64" id="{name}">{text}</script>')
        return name

    runs: dict[Path, int] = {}
    facts: list[dict[str, Any]] = []
    entries = []
    for one in shown:
        if one.run.path not in runs:
            runs[one.run.path] = len(facts)
            facts.append(run_facts(one.run))
        table = rule_table(one)
        entries.append(
            {
                **figures(one),
                "run": runs[one.run.path],
                "history": block(_json(history(one))),
                "rules": None if table is None else block(_json(table)),
                "replay": None if one.recording is None else block(pack_replay(one.recording)),
            }
        )
    index = block(_json({"title": title, "runs": facts, "entries": entries}))
    files = resources.files("slcs2_jax.looking") / "page_assets"
    parts = {
        "MARK": MARK,
        "TITLE": html.escape(title),
        "VERSION": html.escape(__version__),
        "STYLE": (files / "page.css").read_text("utf-8"),
        "DATA": "\n".join(blocks),
        "INDEX": index,
        "PROGRAM": "\n".join((files / name).read_text("utf-8") for name in _PROGRAM),
    }
    return _PLACE.sub(lambda place: parts[place[1]], (files / "page.html").read_text("utf-8"))


def _json(value: Any) -> bytes:
    return zlib.compress(json.dumps(value, allow_nan=False, separators=(",", ":")).encode(), 9)
