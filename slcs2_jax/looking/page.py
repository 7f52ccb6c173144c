"""The page on a run: every instance's search; of the best ones the rules and a replay too."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import Any

from slcs2_jax.looking.document import Blocks, document
from slcs2_jax.looking.page_data import Shown, figures, history, rule_table, run_facts
from slcs2_jax.looking.page_replay import pack_replay
from slcs2_jax.results.files import write_text

PAGE = "report.html"

_PROGRAMS = ("curves.js", "rules.js", "scene.js", "replay.js", "run.js")


def write_page(path: Path, title: str, shown: Iterable[Shown]) -> None:
    """Write the page whole. Raises StorageError."""
    write_text(path, page(title, shown))


def page(title: str, shown: Iterable[Shown]) -> str:
    """The HTML. Of each instance in `shown`, which is gone through once, nothing is kept but what the page holds."""
    blocks = Blocks()
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
                "history": blocks.json(history(one)),
                "rules": None if table is None else blocks.json(table),
                "replay": None if one.recording is None else blocks.add(pack_replay(one.recording)),
            }
        )
    files = resources.files("slcs2_jax.looking") / "page_assets"
    index = {"title": title, "runs": facts, "entries": entries}
    return document(
        title, "Swarms evolved by SLCS2", files / "run.html", [files / name for name in _PROGRAMS], index, blocks
    )
