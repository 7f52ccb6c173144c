"""The page of the suite: one HTML file with tables to sort, intervals, profiles, and what the entries are.

And the same as Markdown and CSV, for documentation and spreadsheets.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from slcs2_jax.config.escape import markdown
from slcs2_jax.looking.document import Blocks, document
from slcs2_jax.results.csv_text import csv_text
from slcs2_jax.results.files import write_text
from slcs2_jax.suite.entries import shipped
from slcs2_jax.suite.rows import HEADER, as_markdown, printed, profiles, row, winners
from slcs2_jax.suite.statistics import LEVELS, Estimate, mean
from slcs2_jax.suite.table import Table

Cells = list[dict[str, Any]]


def write_all(folder: Path, table: Table, replays: Iterable[tuple[dict[str, Any], bytes]] = ()) -> list[Path]:
    """Write index.html, table.md and the tables as CSV into a folder that exists; the files.

    replays: facts and packed episodes, as `shown` gives them.

    Raises StorageError.
    """
    found = tables(table)
    files = {"index.html": _page(table, found, replays), "table.md": _markdown(table, found)}
    for name, (_, header, rows) in found.items():
        files[f"{name}.csv"] = csv_text(header, [[cell["text"] for cell in line] for line in rows])
    for name, text in files.items():
        write_text(folder / name, text)
    return [folder / name for name in files]


Tables = Mapping[str, tuple[str, Sequence[str], Sequence[Cells]]]


def tables(table: Table) -> Tables:
    """By name: title, header, rows of cells (`text` as it is read, `sort` by which it is sorted)."""
    names = [world.name for world in table.worlds]
    over_all = [entry for entry in table.entries if table.common_worlds(entry) == names]
    overall = [[_cell(value) for value in row(table, entry, names).values()] for entry in over_all]
    best = winners(table)
    by_world = []
    for world in table.worlds:
        means = [
            mean([table.scores(entry, world.name)]) if (entry, world.name) in table.results else None
            for entry in table.entries
        ]
        by_world.append([_cell(world.title), *map(_cell, means), _cell(table.bounds[world.name])])
    counts = [
        [_cell(value) for value in (world.title, *row(table, entry, [world.name]).values())]
        for world in table.worlds
        for entry in table.entries
        if (entry, world.name) in table.results
    ]
    kinds = f"{len(names)} of {len(table.suite.worlds)} kinds of worlds"
    return {
        "overall": (f"Over {kinds}, each counting alike", HEADER, overall),
        "winners": (
            "Who is best in each kind of world",
            list(best[0]) if best else [],
            [[_cell(value) for value in one.values()] for one in best],
        ),
        "worlds": ("Fitness in each kind of world", ["world", *table.entries.values(), "bound"], by_world),
        "every": ("Every entry in every kind of world", ["world", *HEADER], counts),
    }


def _cell(value: Any) -> dict[str, Any]:
    sort = value.value if isinstance(value, Estimate) else value
    return {"text": printed(value), "sort": sort}


def about(table: Table) -> list[str]:
    """What the tables are of, in sentences."""
    reference = table.entries.get(table.suite.reference, table.suite.reference)
    lines = [
        f"{table.suite.version}: {len(table.entries)} entries in {len(table.worlds)} of {len(table.suite.worlds)} "
        "kinds of worlds. Fitness is the share of the packets delivered less the share of the time used.",
        "Intervals are 95 % bootstrap intervals over test worlds, stratified by kind; IQM is the interquartile mean; "
        f"better than is the chance to be better than {reference} in the same world. The bound is the "
        "fitness of the least time that speed, distances and links allow.",
    ]
    left_out = [
        f"{title}: in {len(table.common_worlds(entry))} of {len(table.worlds)} of them, and so in no figure over all"
        for entry, title in table.entries.items()
        if len(table.common_worlds(entry)) < len(table.worlds)
    ]
    return lines + left_out


def _page(table: Table, found: Tables, replays: Iterable[tuple[dict[str, Any], bytes]]) -> str:
    blocks = Blocks()
    index = {
        "about": about(table),
        "tables": [
            {"name": name, "title": title, "header": list(header), "rows": rows,
             "csv": csv_text(header, [[cell["text"] for cell in line] for line in rows])}
            for name, (title, header, rows) in found.items()
            if rows
        ],
        "figures": _figures(table),
        "replays": [{**facts, "replay": blocks.add(packed)} for facts, packed in replays],
        "rules": [
            {"title": one.title, "about": one.about, "text": one.content}
            for name, one in shipped().items()
            if name in table.entries and one.content
        ],
    }  # fmt: skip
    files = resources.files(__package__) / "page_assets"
    title = f"Benchmark {table.suite.version}"
    looking = resources.files("slcs2_jax.looking") / "page_assets"
    programs = [looking / "scene.js", looking / "replay.js", files / "suite.js"]
    return document(title, "Entries compared in frozen worlds", files / "suite.html", programs, index, blocks)


def _figures(table: Table) -> list[dict[str, Any]]:
    names = [world.name for world in table.worlds]
    over_all = [entry for entry in table.entries if table.common_worlds(entry) == names]
    found: list[dict[str, Any]] = []
    if over_all:
        values = [mean([table.scores(entry, world) for world in names]) for entry in over_all]
        found.append({
            "name": "suite_fitness", "title": "Mean fitness",
            "caption": "Over all kinds of worlds of the table, with the 95 % interval.",
            "x": {"label": "entry", "names": [table.entries[entry] for entry in over_all]}, "y": {"label": "fitness"},
            "series": [{
                "label": "fitness", "kind": "dots", "ys": [one.value for one in values],
                "low": [one.low for one in values], "high": [one.high for one in values],
            }],
        })  # fmt: skip
    curves = [
        {"label": table.entries[entry], "kind": "line", "ys": value, "low": low, "high": high}
        for entry, (value, low, high) in profiles(table).items()
    ]
    if curves:
        found.append({
            "name": "suite_profiles", "title": "Performance profiles",
            "caption": "Share of the test worlds in which an entry's fitness is above the figure below, and its 95 % "
            "interval: higher is better.",
            "x": {"label": "fitness"}, "y": {"label": "share of test worlds"},
            "xs": [round(float(level), 3) for level in LEVELS], "series": curves,
        })  # fmt: skip
    return found


def _markdown(table: Table, found: Tables) -> str:
    parts = ["\n\n".join(map(markdown, about(table)))]
    for title, header, rows in found.values():
        if rows:
            parts.append(f"## {title}\n\n{as_markdown(header, [[cell['text'] for cell in line] for line in rows])}")
    return "\n\n".join(parts).rstrip() + "\n"
