"""The rows of the table: what an entry came to, who is best in each kind of world, and how rows are printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from slcs2_jax.config.escape import markdown, terminal
from slcs2_jax.study.statistics import holm_of
from slcs2_jax.suite.statistics import Estimate, improvement, interquartile_mean, mean, paired_p, profile
from slcs2_jax.suite.table import Table

HEADER = (
    *("entry", "field", "fitness", "IQM", "better than", "delivered", "time", "gap to the bound"),
    *("between trainings", "trainings", "worlds", "deployments", "episodes spent", "env-steps spent"),
)


def row(table: Table, entry: str, worlds: Sequence[str]) -> dict[str, Any]:
    """The figures of an entry over these kinds of worlds, of each alike; by the names of `HEADER`.

    fitness, IQM, better than: `Estimate`; the last against the suite's reference, None for itself. delivered, time:
    shares of the packets and of the time limit. gap to the bound: of the mean fitness to that of `bound`. between
    trainings: standard deviation of their means, None where there is one. The rest are counts.
    """
    results = [table.results[entry, world] for world in worlds]
    strata = [table.scores(entry, world) for world in worlds]
    reference = table.suite.reference
    known = [world for world in worlds if (reference, world) in table.results]
    rival = entry != reference and known
    pairs = [table.paired(entry, reference, world) for world in known]
    fitness = mean(strata)
    of = [table.suite.worlds[world] for world in worlds]
    spreads = [
        one.fitness(world).mean(axis=(1, 2)).std(ddof=1)
        for one, world in zip(results, of, strict=True)
        if len(one.steps) > 1
    ]
    return {
        "entry": table.entries[entry],
        "field": results[0].field,
        "fitness": fitness,
        "IQM": interquartile_mean(strata),
        "better than": improvement(pairs) if rival else None,
        "delivered": float(
            np.mean([one.delivered.mean() / world.packets for one, world in zip(results, of, strict=True)])
        ),
        "time": float(np.mean([one.steps.mean() / world.time_limit for one, world in zip(results, of, strict=True)])),
        "gap to the bound": float(np.mean([table.bounds[world] for world in worlds])) - fitness.value,
        "between trainings": float(np.mean(spreads)) if spreads else None,
        "trainings": _span([len(one.steps) for one in results]),
        "worlds": sum(len(one.seeds) for one in results),
        "deployments": sum(one.steps.size for one in results),
        "episodes spent": sum(one.episodes for one in results),
        "env-steps spent": sum(one.env_steps for one in results),
    }


def winners(table: Table) -> list[dict[str, Any]]:
    """For each kind of world who is best, by how much over the second, and whether the others are significantly worse.

    p of the paired test of the best against each other entry, corrected by Holm over all of these tests.
    """
    found, p_values = [], {}
    for world in table.worlds:
        names = [name for name in table.entries if (name, world.name) in table.results]
        ranked = sorted(names, key=lambda name: -float(table.scores(name, world.name).mean()))
        for other in ranked[1:]:
            p_values[world.name, other] = paired_p(*table.paired(ranked[0], other, world.name))
        found.append((world, ranked))
    corrected = {key: p for key, p in zip(p_values, holm_of([*p_values.values()]), strict=True) if p is not None}
    rows = []
    for world, ranked in found:
        means = [float(table.scores(name, world.name).mean()) for name in ranked]
        level = [table.entries[name] for name in ranked[1:] if corrected[world.name, name] >= 0.05]
        rows.append({
            "world": world.title,
            "best": table.entries[ranked[0]],
            "fitness": means[0],
            "second": table.entries[ranked[1]] if len(ranked) > 1 else None,
            "ahead by": means[0] - means[1] if len(ranked) > 1 else None,
            "p (Holm)": corrected[world.name, ranked[1]] if len(ranked) > 1 else None,
            "not significantly worse": ", ".join(level) or "none",
            "gap to the bound": table.bounds[world.name] - means[0],
        })  # fmt: skip
    return rows


def profiles(table: Table) -> dict[str, tuple[list[float], list[float], list[float]]]:
    """The performance profile of each entry that was in all kinds of worlds of the table."""
    names = [name for name in table.entries if len(table.common_worlds(name)) == len(table.worlds)]
    return {name: profile([table.scores(name, world.name) for world in table.worlds]) for name in names}


def _span(counts: Sequence[int]) -> str:
    low, high = min(counts), max(counts)
    return str(low) if low == high else f"{low} to {high}"


def printed(value: Any) -> str:
    """A figure as it stands in a table."""
    if value is None:
        return "–"
    if isinstance(value, Estimate):
        if value.low is None:
            return f"{value.value:.3f}"
        return f"{value.value:.3f} [{value.low:.3f}, {value.high:.3f}]"
    if isinstance(value, float):
        return f"{value:.3f}" if abs(value) >= 0.001 or value == 0 else f"{value:.1e}"
    return f"{value:,d}" if isinstance(value, int) else str(value)


Rows = Sequence[Sequence[str]]


def as_text(header: Sequence[str], rows: Rows) -> str:
    """Columns for a terminal."""
    lines = [[terminal(cell) for cell in line] for line in (header, *rows)]
    widths = [max(len(line[at]) for line in lines) for at in range(len(header))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def as_markdown(header: Sequence[str], rows: Rows) -> str:
    """A table of a page of the documentation."""
    lines = [[markdown(cell) for cell in line] for line in (header, *rows)]
    lines.insert(1, ["---"] * len(header))
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
