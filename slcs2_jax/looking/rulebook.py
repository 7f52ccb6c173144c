"""What a solution's rules say, what they learnt, how often they acted, and where they came from.

[n, R] = agents, rules.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.looking.recording import NOBODY, Recording
from slcs2_jax.results import SavedSolution
from slcs2_jax.results.saved import reflex_mark

INITIAL, RANDOM, COPIED = range(3)  # kinds of origin, as saved solutions have them


@dataclass(frozen=True, kw_only=True)
class RuleLine:
    """One rule of one agent. `matched` and `chosen`: steps of a replay in which its condition held, and in which it was
    the one drawn or the reflex; None without a replay. The text of a reflex begins with `reflex: `."""

    agent: int
    index: int
    rule: str
    quality: float
    strength: float
    error: float
    usage: int
    matched: int | None
    chosen: int | None
    origin: str


@dataclass(frozen=True, kw_only=True)
class Spread:
    """A rule that exchange brought to agents: who holds it now, and how it came to each."""

    rule: str
    holders: tuple[int, ...]
    copies: tuple[tuple[int, int, int], ...]  # generation, from agent, to agent; in that order


SORTS = {"strength": "strength", "use": "usage", "quality": "quality"}


def origin_text(kind: int, generation: int, agent: int) -> str:
    """Where a rule came from, in words."""
    if kind == INITIAL:
        return "initial"
    if kind == RANDOM:
        return f"random in generation {generation}"
    return f"copied from agent {agent} in generation {generation}"


def chosen_counts(recording: Recording) -> NDArray[np.int64]:
    """In how many steps of a replay each rule was the one drawn: int64 [n, R]."""
    counts = np.zeros(recording.matched.shape, np.int64)
    step, agent = np.nonzero(recording.rule != NOBODY)
    np.add.at(counts, (agent, recording.rule[step, agent]), 1)
    return counts


def rule_lines(solution: SavedSolution, recording: Recording | None = None, sort: str = "strength") -> list[RuleLine]:
    """Every rule of every agent, agent by agent, the greatest `sort` (of `SORTS`) first."""
    chosen = None if recording is None else chosen_counts(recording)
    lines = []
    for agent in range(solution.agents):
        key = getattr(solution, SORTS[sort])[agent].astype(np.float64)
        for index in np.argsort(-key, kind="stable").tolist():
            place = agent, index
            lines.append(
                RuleLine(
                    agent=agent,
                    index=index,
                    rule=reflex_mark(solution.rules, agent, index) + solution.rules.text(agent, index),
                    quality=float(solution.quality[place]),
                    strength=float(solution.strength[place]),
                    error=float(solution.error[place]),
                    usage=int(solution.usage[place]),
                    matched=None if recording is None else int(recording.matched[place]),
                    chosen=None if chosen is None else int(chosen[place]),
                    origin=_origin(solution, agent, index),
                )
            )
    return lines


def acting(lines: list[RuleLine], agent: int) -> list[RuleLine]:
    """An agent's condition => action pairs over a replay, the most frequent first; equal rules are one."""
    merged: dict[str, RuleLine] = {}
    for line in lines:
        if line.agent != agent or not line.chosen:
            continue
        known = merged.get(line.rule)
        total = line.chosen + (0 if known is None else known.chosen or 0)
        merged[line.rule] = RuleLine(**{**vars(known or line), "chosen": total})
    return sorted(merged.values(), key=lambda line: (-(line.chosen or 0), line.index))


def spread_rules(solution: SavedSolution) -> list[Spread]:
    """Rules that at least one agent has from another, those with the most holders first."""
    ids = solution.rules.ids()
    kind, generation, donor = (
        np.asarray(getattr(solution, f"origin_{name}")) for name in ("kind", "generation", "agent")
    )
    found = []
    for one in np.unique(ids[kind == COPIED]):
        agents, indices = np.nonzero(ids == one)
        came = {
            (int(generation[place]), int(donor[place]), int(place[0]))
            for place in zip(agents.tolist(), indices.tolist(), strict=True)
            if kind[place] == COPIED
        }
        rule = solution.rules.text(int(agents[0]), int(indices[0]))
        found.append(Spread(rule=rule, holders=tuple(sorted(set(agents.tolist()))), copies=tuple(sorted(came))))
    return sorted(found, key=lambda one: (-len(one.holders), one.rule))


def _origin(solution: SavedSolution, agent: int, index: int) -> str:
    arrays = (solution.origin_kind, solution.origin_generation, solution.origin_agent)
    kind, generation, donor = (int(np.asarray(array)[agent, index]) for array in arrays)
    return origin_text(kind, generation, donor)
