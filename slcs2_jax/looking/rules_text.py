"""Rules for people and programs to read: text for a terminal, CSV with a row per rule, one JSON document."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from slcs2_jax.config.escape import terminal
from slcs2_jax.looking.rulebook import RuleLine, Spread, acting
from slcs2_jax.results import SavedSolution
from slcs2_jax.results.csv_text import csv_text

MOST_SPREAD = 12  # rules that the text lists as spread by exchange


@dataclass(frozen=True, kw_only=True)
class Rulebook:
    """What is shown of a solution.

    Attributes:
        solution: whose rules these are.
        lines: its rules, of the agents that are asked for.
        spread: what exchange spread.
        replay_fitness, steps: of the replay that was looked at; None without one.
    """

    solution: SavedSolution
    lines: Sequence[RuleLine]
    spread: Sequence[Spread]
    replay_fitness: float | None
    steps: int | None

    @property
    def agents(self) -> list[int]:
        """The agents whose rules are here."""
        return sorted({line.agent for line in self.lines})

    def about(self) -> dict[str, Any]:
        """What solution it is."""
        one = self.solution
        return {
            "environment": one.settings.world.environment,
            "range": one.settings.world.range,
            "seed": one.instance_seed,
            "grammar": one.settings.rules.grammar,
            "generation": one.generation,
            "fitness": one.fitness,
            "deployments": one.deployments,
            "replay_fitness": self.replay_fitness,
            "replay_steps": self.steps,
        }

    def json(self) -> str:
        """Everything, as one document."""
        document = {
            **self.about(),
            "contribution": self.solution.contribution.tolist(),
            "rules": [asdict(line) for line in self.lines],
            "spread": [asdict(one) for one in self.spread],
        }
        return json.dumps(document, indent=1, allow_nan=False) + "\n"

    def csv(self) -> str:
        """A row for each agent and rule."""
        header = tuple(asdict(self.lines[0]))
        return csv_text(header, (tuple(asdict(line).values()) for line in self.lines))

    def text(self, top: int) -> str:
        """For a terminal: each agent's first `top` rules (0: all), what it did most, and what exchange spread.

        Nothing in it controls the terminal.
        """
        one, about = self.solution, self.about()
        parts = [
            f"{about['range']} {about['environment']}, seed {about['seed']}, grammar {about['grammar']}: solution of "
            f"generation {about['generation']}, fitness {one.fitness:.3f} over {one.deployments} deployment(s)"
            + ("" if self.replay_fitness is None else f"; this replay {self.replay_fitness:.3f} in {self.steps} steps")
        ]
        for agent in self.agents:
            parts.append(self._agent(agent, top))
        parts.append(self._spread_text())
        return terminal("\n\n".join(parts) + "\n", lines=True)

    def _agent(self, agent: int, top: int) -> str:
        own = [line for line in self.lines if line.agent == agent]
        shown = own[:top] if top else own
        replayed = self.steps is not None
        lines = [f"agent {agent}   contribution {self.solution.contribution[agent]:.1f}"]
        lines.append(
            f"{'q':>7} {'zeta':>8} {'eps':>7} {'tau':>6}{' matched  chosen' if replayed else ''}  rule  [origin]"
        )
        for line in shown:
            counts = f" {line.matched:>7} {line.chosen:>7}" if replayed else ""
            lines.append(
                f"{line.quality:7.2f} {line.strength:8.4f} {line.error:7.2f} {line.usage:6d}{counts}  {line.rule}  "
                f"[{line.origin}]"
            )
        if len(own) > len(shown):
            lines.append(f"... and {len(own) - len(shown)} more (top=0 shows all)")
        if replayed and self.steps:
            lines.append("most often:")
            lines += [
                f"{(line.chosen or 0) / self.steps:7.1%}  {line.rule}" for line in acting(list(self.lines), agent)[:5]
            ]
        return "\n".join(lines)

    def _spread_text(self) -> str:
        if not self.spread:
            return "no rule came from another agent"
        lines = [f"spread by exchange: {len(self.spread)} rules, the most widely held first"]
        for one in self.spread[:MOST_SPREAD]:
            holders = ", ".join(map(str, one.holders))
            lines.append(f"{len(one.holders):3d} agents ({holders})  {one.rule}")
            copies = ", ".join(f"{giver} to {taker} ({generation})" for generation, giver, taker in one.copies[:6])
            lines.append(f"      copied (in generation): {copies}{', ...' if len(one.copies) > 6 else ''}")
        if len(self.spread) > MOST_SPREAD:
            lines.append(f"... and {len(self.spread) - MOST_SPREAD} more (format=json has all)")
        return "\n".join(lines)
