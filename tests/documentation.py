"""Code blocks of the README and of the pages of the documentation, and a reader who runs them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
PAGES = sorted(path for path in (ROOT / "docs").rglob("*.md") if "results" not in path.parts)

_BLOCK = re.compile(r"(<!-- not run[^\n]*-->\n)?^```(\w*)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_TITLE = re.compile(r'title="([\w.]+)"')
_SNIPPET = re.compile(r'^--8<-- "([^"]+)"\n', re.MULTILINE)
_COMMANDS = {"bash": ["bash", "-euo", "pipefail", "-c"], "python": [sys.executable, "-W", "error", "-c"]}


class Block(NamedTuple):
    """A code block; `title` is the file that the reader saves it as, "" for none, and `runs` whether it is run."""

    kind: str
    title: str
    text: str
    runs: bool


def blocks(page: Path) -> list[Block]:
    """The code blocks of a page in order, with the files that they include."""
    found = []
    for remark, kind, rest, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        title = _TITLE.search(rest)
        whole = _SNIPPET.sub(lambda match: (ROOT / match[1]).read_text(encoding="utf-8"), text)
        runs = not remark and title is None and kind in _COMMANDS
        found.append(Block(kind, title[1] if title else "", whole, runs))
    return found


def follow(block: Block, folder: Path, cache: Path) -> None:
    """Save a block, or run it in the folder, where it finds what those before it left; it must show something."""
    if block.title:
        (folder / block.title).write_text(block.text, encoding="utf-8")
    if not block.runs:
        return
    kept = {variable: value for variable, value in os.environ.items() if not variable.startswith(("JAX_", "XLA_"))}
    path = f"{Path(sys.executable).parent}{os.pathsep}{kept['PATH']}"  # what activating does
    done = subprocess.run(
        [*_COMMANDS[block.kind], block.text],
        cwd=folder,
        env=kept | {"PATH": path, "JAX_PLATFORMS": "cpu", "XDG_CACHE_HOME": str(cache)},
        capture_output=True,
        text=True,
        timeout=1800,
    )
    assert done.returncode == 0, block.text + done.stdout + done.stderr
    assert done.stdout.strip(), f"it shows nothing: {block.text}"
