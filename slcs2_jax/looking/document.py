"""A page as one HTML file that needs no network: its data, its program and its style are in it. No JAX."""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Sequence
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from slcs2_jax import __version__
from slcs2_jax.config import InputError
from slcs2_jax.config.door import reading
from slcs2_jax.results.files import storing

MARK = '<meta name="generator" content="slcs2_jax report">'  # by which an earlier page is known as ours

_ASSETS = resources.files("slcs2_jax.looking") / "page_assets"
_LARGEST = 2**40  # bytes of an earlier page; its head alone is read
_VENDOR = _ASSETS / "vendor"
_COMMON = ("common.js", "svg.js", "plot.js")
_PLACE = re.compile(r"@@(\w+)@@")


class Blocks:
    """Data that the page's program finds by names. Base64 holds no `<`: nothing in it can end the element."""

    def __init__(self) -> None:
        self._made: list[str] = []

    def add(self, data: bytes) -> str:
        """Keep bytes that zlib compressed; returns their name."""
        name = f"data-{len(self._made)}"
        text = base64.b64encode(data).decode("ascii")
        self._made.append(f'<script type="application/octet-stream;base64" id="{name}">{text}</script>')
        return name

    def json(self, value: Any) -> str:
        """Keep a plain value; returns its name."""
        return self.add(zlib.compress(json.dumps(value, allow_nan=False, separators=(",", ":")).encode(), 9))

    def __str__(self) -> str:
        return "\n".join(self._made)


def document(
    title: str,
    about: str,
    main: Traversable,
    programs: Sequence[Traversable],
    index: Any,
    blocks: Blocks,
    *,
    apart: str = "",
) -> str:
    """The HTML: frame.html with what is the page's own.

    Args:
        title: of the page.
        about: what it shows, in a word or two.
        main: the HTML of what is below the title.
        programs: scripts beside those that all pages share.
        index: what `showPage` hands to the page's program.
        blocks: further data, by names that the index may hold.
        apart: " but ...", what is in other files.
    """
    licence = f"/* uPlot\n{_text(_VENDOR / 'LICENSE')}*/"
    shared = [_text(_VENDOR / "uPlot.iife.min.js"), *(_text(_ASSETS / name) for name in _COMMON)]
    parts = {
        "MARK": MARK,
        "TITLE": html.escape(title),
        "ABOUT": html.escape(about),
        "APART": html.escape(apart),
        "MAIN": _text(main),
        "VERSION": html.escape(__version__),
        "STYLE": _text(_VENDOR / "uPlot.min.css") + _text(_ASSETS / "page.css"),
        "INDEX": blocks.json(index),
        "DATA": str(blocks),
        "PROGRAM": "\n".join([licence, *shared, *(_text(one) for one in programs)]),
    }
    return _PLACE.sub(lambda place: parts[place[1]], _text(_ASSETS / "frame.html"))


def is_page(path: Path) -> bool:
    """Is this a file with a page that was made here? Raises StorageError."""
    try:
        with storing(path, "read"), reading(path, _LARGEST) as file:
            return MARK.encode() in file.read(1000)
    except InputError:  # a link, a folder, a device
        return False


def _text(file: Traversable) -> str:
    return file.read_text("utf-8")
