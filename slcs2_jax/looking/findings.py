"""What winners do that their designer does not, in words: reflexes switched off, rules that act, how packets travel.

n, R = agents, rules; K = rules of knowledge, in the first places of every rule-set.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slcs2_jax.results import FinishedRun, SavedSolution

_MOST_RULES = 6  # that are named


@dataclass(frozen=True, eq=False, kw_only=True)
class Findings:
    """Of one solution, by the deployments that evaluated it.

    Attributes:
        reflexes: of each rule of knowledge, the share of agents in which it is a reflex; none without reflexes.
        by_reflex: share of all acts that were a reflex's doing.
        actions: of each action, its share of all acts, and that of acts with it that no reflex brought about; the
            greatest first.
        acting: of each rule that was no reflex, the share of all acts in which it took part beyond those that a reflex
            brought about, the greatest first.
        delivered: mean packets at the sink in the deployments of its generation; None where the row is not there.
        carriers: agents that a delivered packet passes through, in the mean; None if nothing was delivered.
        carrying: how many agents share the carrying: 1 / sum of squared shares, from 1 to n; None likewise.
    """

    reflexes: dict[str, float]
    by_reflex: float
    actions: dict[str, tuple[float, float]]
    acting: dict[str, float]
    delivered: float | None
    carriers: float | None
    carrying: float | None


def findings(solution: SavedSolution, run: FinishedRun | None = None, instance: int = 0) -> Findings:
    """What is to be said of a solution; `run` and `instance` it comes from, for its row.

    In an act take part all rules that hold and say the same, and usage counts that. So an agent acted in one way as
    often as the rule that took part most often, and reflexes did as often as the one among them.
    """
    rules, usage = solution.rules, solution.usage.astype(np.float64)
    flags = rules.reflex if rules.reflex is not None else np.zeros(usage.shape, bool)
    acts, by_reflex = _acts(rules.action, usage), _acts(rules.action, np.where(flags, usage, 0))
    total = max(sum(float(count.sum()) for count in acts.values()), 1.0)
    known = _known(solution)
    places = {rules.text(0, place): float(flags[:, place].mean()) for place in range(known)}
    own: dict[tuple[str, int], float] = {}  # by rule and agent, which may have it in several places
    for agent, place in np.argwhere((usage > 0) & ~flags).tolist():
        beyond = float(usage[agent, place] - by_reflex[int(rules.action[agent, place])][agent])
        if beyond > 0:
            rule = rules.text(agent, place), agent
            own[rule] = max(beyond, own.get(rule, 0.0))
    acting: Counter[str] = Counter()
    for (text, _), count in own.items():
        acting[text] += count  # type: ignore[assignment]
    row = _row(solution, run, instance)
    held = (row or {}).get("contribution", solution.contribution)  # archives may have left it out of the rows
    contribution = np.array(held, np.float64)
    delivered = None if row is None else float(row["delivered"])
    moved = contribution.sum()
    return Findings(
        reflexes=places if rules.reflex is not None else {},
        by_reflex=sum(float(count.sum()) for count in by_reflex.values()) / total,
        actions={
            rules.vocabulary.action_text(one): (count.sum() / total, (count - by_reflex[one]).sum() / total)
            for one, count in sorted(acts.items(), key=lambda item: -item[1].sum())
        },
        acting={text: count / total for text, count in acting.most_common()},
        delivered=delivered,
        carriers=float(moved / delivered) if delivered else None,
        carrying=float(moved**2 / (contribution**2).sum()) if moved else None,
    )


def _acts(action: np.ndarray, usage: np.ndarray) -> dict[int, np.ndarray]:
    """By action, how often each agent did it, float64[n]: the usage of the rule that took part most often."""
    return {int(one): np.where(action == one, usage, 0).max(axis=1) for one in np.unique(action)}


def _known(solution: SavedSolution) -> int:
    """K: the first places in which all agents have the same rule; 0 without reflexes."""
    if solution.rules.reflex is None:
        return 0
    ids = solution.rules.ids()
    same = (ids == ids[:1]).all(axis=0)
    return int(np.argmin(same)) if not same.all() else len(same)


def _row(solution: SavedSolution, run: FinishedRun | None, instance: int) -> dict[str, Any] | None:
    place = instance, solution.generation
    rows = () if run is None else run.rows
    return next((row for row in rows if (row["instance"], row["generation"]) == place), None)


def in_words(found: Findings, agents: int) -> list[str]:
    """A sentence or two for each of the three, for people."""
    lines = []
    if found.reflexes:
        off = [text for text, share in found.reflexes.items() if share == 0]
        on = [text for text, share in found.reflexes.items() if share == 1]
        some = {text: round(share * agents) for text, share in found.reflexes.items() if 0 < share < 1}
        lines.append(f"Reflexes in every agent: {'; '.join(on) or 'none'}.")
        if off:
            lines.append(f"The designer's rules that are a reflex of nobody: {'; '.join(off)}.")
        if some:
            told = "; ".join(f"{text} ({count} of {agents})" for text, count in some.items())
            lines.append(f"In some agents: {told}.")
        lines.append(f"Reflexes did {found.by_reflex:.0%} of all that was done, what was learnt the rest.")
    most = list(found.acting.items())[:_MOST_RULES]
    if most:
        told = "; ".join(f"{text} ({share:.1%})" for text, share in most)
        lines.append(f"Of the rules that are chosen by what they learnt, these acted most: {told}.")
    if found.carriers is not None and found.carrying is not None:
        lines.append(
            f"A delivered packet passed through {found.carriers:.1f} agents in the mean; the carrying was shared as if "
            f"{found.carrying:.1f} of {agents} agents did it alike."
        )
    return lines


def reflex_shares(several: Sequence[Findings]) -> dict[str, float]:
    """Of each rule of knowledge, the mean share of agents in which it is a reflex, over winners that have reflexes."""
    known = [one.reflexes for one in several if one.reflexes]
    texts = list(dict.fromkeys(text for one in known for text in one))
    return {text: float(np.mean([one.get(text, 0.0) for one in known])) for text in texts}


def acting_shares(several: Sequence[Findings]) -> list[tuple[str, float, int]]:
    """Rules that are chosen by what they learnt: mean share of all acts, and in how many winners it acts."""
    total: Counter[str] = Counter()
    count: Counter[str] = Counter()
    for one in several:
        for text, share in one.acting.items():
            total[text] += share  # type: ignore[assignment]
            count[text] += 1
    return [(text, share / len(several), count[text]) for text, share in total.most_common()]
