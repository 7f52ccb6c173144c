"""What the page says of each instance of a run, as plain values for JSON; the replay apart, see `page_replay`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slcs2_jax.config import Settings
from slcs2_jax.config.field import show
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.config.worlds import worlds_of
from slcs2_jax.looking.findings import findings, in_words
from slcs2_jax.looking.recording import Recording
from slcs2_jax.looking.rulebook import rule_lines
from slcs2_jax.results import FinishedRun, SavedSolution
from slcs2_jax.results.arm import CELLS, arm_of, arm_title, cell_of, ordered

MOST_ROWS = 2000  # generations of an instance that are drawn
_COLUMNS = ("generation", "fitness", "best", "size", "novelty", "accepted")


@dataclass(frozen=True, kw_only=True)
class Shown:
    """An instance of a run as the page shows it: with its best solution and a replay of that, where there are such.

    `note` says in a line what is missing and why; "" if nothing is.
    """

    run: FinishedRun
    instance: int
    solution: SavedSolution | None = None
    recording: Recording | None = None
    deployment: int = 0
    note: str = ""

    @property
    def rows(self) -> dict[int, Mapping[str, Any]]:
        """The instance's rows by generation, in order."""
        return rows_of(self.run, self.instance)

    @property
    def winner(self) -> int | None:
        """The generation of the best solution; None before the first."""
        if self.solution is not None:
            return self.solution.generation
        last = next(reversed(self.rows.values()), None)
        return None if last is None else last.get("best_generation")


def rows_of(run: FinishedRun, instance: int) -> dict[int, Mapping[str, Any]]:
    """The rows of an instance by generation, in order."""
    own = [row for row in run.rows if row.get("instance") == instance and isinstance(row.get("generation"), int)]
    return {row["generation"]: row for row in sorted(own, key=lambda row: row["generation"])}


def fresh_mean(run: FinishedRun, instance: int) -> float | None:
    """The winner's mean over fresh deployments; None before the run has ended."""
    return run.summary["instances"][instance].get("fresh_mean") if run.summary else None


def best_so_far(run: FinishedRun, instance: int) -> float:
    """The greatest fitness of an instance; -inf before its first generation."""
    return max(
        (float(row["fitness"]) for row in rows_of(run, instance).values() if "fitness" in row), default=-math.inf
    )


def by_rank(runs: Iterable[FinishedRun]) -> list[tuple[FinishedRun, int]]:
    """All instances: the best one of each arm in each world, the paper's algorithm first; then the second best, ...

    By their means over fresh deployments; those that have none yet come last.
    """
    groups: dict[tuple[str, int], list[tuple[FinishedRun, int]]] = {}
    runs = list(runs)
    arms = ordered(arm_of(run.settings) for run in runs)
    for run in runs:
        for instance in range(run.settings.instances):
            place = arm_of(run.settings), CELLS.index(cell_of(run.settings))
            groups.setdefault(place, []).append((run, instance))
    ranked = []
    for (arm, cell), members in groups.items():
        members.sort(key=_by_fresh_mean)
        ranked += [((rank, arms.index(arm), cell), one) for rank, one in enumerate(members)]
    return [one for _, one in sorted(ranked, key=lambda pair: pair[0])]


def _by_fresh_mean(one: tuple[FinishedRun, int]) -> tuple[bool, float]:
    mean = fresh_mean(*one)
    return mean is None, -(mean or 0.0)


def figures(shown: Shown) -> dict[str, Any]:
    """The figures of an instance, for its line in the list of all; null where one is not known (yet)."""
    run, rows = shown.run, shown.rows
    summary = run.summary["instances"][shown.instance] if run.summary else {}
    best = best_so_far(run, shown.instance)
    settings = run.settings
    return {
        "arm": arm_title(arm_of(settings)),
        "world": cell_of(settings).title,
        "seed": settings.seed + shown.instance,
        "instance": shown.instance,
        "generations": len(rows),
        "planned": settings.search.generations,
        "ended": run.summary is not None,
        "best": _number(best) if math.isfinite(best) else None,
        "winner": shown.winner,
        "fresh_mean": _number(summary.get("fresh_mean")),
        "fresh_sd": _number(summary.get("fresh_sd")),
        "fresh": settings.search.fresh_deployments,
        "evaluations": summary.get("evaluations"),
        "env_steps": summary.get("env_steps"),
        "deployment": shown.deployment,
        "note": shown.note,
        "found": _found(shown),
    }


def _found(shown: Shown) -> list[str]:
    """What its solution does, in words; nothing of an instance that is shown without."""
    if shown.solution is None:
        return []
    return in_words(findings(shown.solution, shown.run, shown.instance), shown.solution.agents)


def run_facts(run: FinishedRun) -> dict[str, Any]:
    """What all instances of a run share: its settings, its world, and what made it."""
    record, settings = run.record, run.settings
    command = str(record.get("command", ""))
    return {
        "name": run.path.resolve().name,
        "ended": run.summary is not None,
        "settings": changed_settings(settings),
        "world": _world(settings),
        "swarm": f"{settings.swarm.agents} agents with {settings.rules.rules} rules each, {settings.swarm.packets} "
        f"packets, grammar {settings.rules.grammar}",
        "versions": ", ".join(f"{name} {version}" for name, version in sorted(record.get("versions", {}).items())),
        "device": str(record.get("device", "")),
        "started": str(record.get("started", "")),
        # what was added for Hydra names a scratch folder, another one every time
        "command": " ".join(word for word in command.split() if not word.startswith("hydra.sweep.")),
    }


def changed_settings(settings: Settings) -> list[list[str]]:
    """Settings that are not at their default: name, value with its unit, default, meaning."""
    changed = []
    for section, field in settings_fields():
        value = getattr(getattr(settings, section) if section else settings, field.attribute)
        if field.attribute == "run_dir" or value == field.default:
            continue
        unit = f" {field.doc.unit}" if field.doc.unit else ""
        changed.append([field.name, f"{show(value)}{unit}", f"{show(field.default)}{unit}", field.doc.help])
    return changed


def _world(settings: Settings) -> str:
    world = settings.world
    if settings.worlds:
        return f"{len(worlds_of(settings))} worlds, deployed in by turns: {', '.join(settings.worlds)}"
    has = [word for word, there in (("buildings", world.buildings), ("a jammer", world.jammer)) if there]
    return (
        f"{cell_of(settings).title}: {world.distance:g} m from source to sink, {' and '.join(has) or 'nothing'} in "
        f"between, {world.time_limit} time-steps at most"
    )


def history(shown: Shown) -> dict[str, Any]:
    """The search of an instance, generation by generation, and the chain of parents of its winner."""
    rows = list(shown.rows.values())
    drawn = _thinned(rows)
    columns = {name: [_number(row.get(name)) for row in drawn] for name in _COLUMNS}
    return {"of": len(rows), "columns": columns, "lineage": lineage(shown), "contribution": _contribution(shown)}


def _thinned(rows: list[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Evenly, and every new best; all, if they are few enough to be drawn."""
    every = -(-len(rows) // MOST_ROWS)
    return [
        row for at, row in enumerate(rows) if at % max(every, 1) == 0 or row.get("best_generation") == row["generation"]
    ]


def lineage(shown: Shown) -> list[dict[str, Any]]:
    """The winner, its parent, that one's parent, ... to the first: generation, fitness and where its rules are from."""
    rows, generation = shown.rows, shown.winner
    settings = shown.run.settings
    rules = settings.swarm.agents * settings.rules.rules
    chain: list[dict[str, Any]] = []
    while generation is not None and generation in rows and "parent" in rows[generation]:
        row = rows[generation]
        chain.append(
            {
                "generation": generation,
                "fitness": _number(row.get("fitness")),
                "copied": row["copied"],
                "fresh": row["fresh"],
                "kept": rules - row["copied"] - row["fresh"],
            }
        )
        generation = row["parent"] if row["parent"] < generation else None
    return chain


def _contribution(shown: Shown) -> list[float]:
    """Of the winner's agents: delivered packets that each had held, mean over its deployments."""
    if shown.solution is not None:
        return [_number(float(value)) for value in shown.solution.contribution]
    return [
        _number(value)
        for value in shown.rows.get(-1 if shown.winner is None else shown.winner, {}).get("contribution", [])
    ]


def rule_table(shown: Shown) -> dict[str, Any] | None:
    """Every rule of the winner, agent by agent in the order of the rules' numbers, in columns; texts stand once."""
    if shown.solution is None:
        return None
    lines = sorted(rule_lines(shown.solution, shown.recording), key=lambda line: (line.agent, line.index))
    texts, text = _once([line.rule for line in lines])
    origins, origin = _once([line.origin for line in lines])
    return {
        "agents": shown.solution.agents,
        "rules": len(lines) // shown.solution.agents,
        "texts": texts,
        "text": text,
        "origins": origins,
        "origin": origin,
        "quality": [_number(line.quality) for line in lines],
        "strength": [_number(line.strength) for line in lines],
        "error": [_number(line.error) for line in lines],
        "usage": [line.usage for line in lines],
        "matched": None if shown.recording is None else [line.matched for line in lines],
        "chosen": None if shown.recording is None else [line.chosen for line in lines],
    }


def _once(values: Sequence[str]) -> tuple[list[str], list[int]]:
    """The different values, and of each which of these it is."""
    places: dict[str, int] = {}
    which = [places.setdefault(value, len(places)) for value in values]
    return list(places), which


def _number(value: Any) -> Any:
    """With as many digits as can matter to a reader."""
    return float(np.format_float_positional(value, 5, fractional=False)) if isinstance(value, float) else value
