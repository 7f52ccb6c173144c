"""What the winners of many runs have in common, as a page in Markdown: by kind of search, and by world side by side."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from slcs2_jax.config.escape import markdown, markdown_code
from slcs2_jax.looking.findings import Findings, acting_shares, reflex_shares

TITLE = "# What evolution found"
_INTRODUCTION = """\
What winners do that their designer does not. Every agent has a list of rules; one says when it may act (clauses, \
joined by `&`) and what it then does (behind `=>`). A *reflex* acts before any choice: the first one that holds. Where \
none does, an agent chooses among its other rules, which evolved, by the quality that it has learnt of them.

`si` and `so` are the neighbours that are next on the way to the sink and to the source, `c` is the closest one; \
`d_si` is the distance to the first of them, `net` the range of the radio, `d_th` the distance below which agents are \
in a crowd. `NI <= P_rs` means that it is quiet: nobody else is heard sending.

Shares are means over winners: of agents in which a rule is a reflex, and of all acts of all agents in the deployments \
that evaluated them."""
_KEPT = 0.75  # share of agents from which on a reflex counts as kept
_MOST_OFF, _MOST_ACTIONS, _MOST_OWN = 4, 10, 3  # that are told of
_NEVER = (0.0, 0.0)

Worlds = Mapping[str, Sequence[Findings]]  # the winners in each world


def page(searches: Mapping[str, Worlds]) -> str:
    """The whole page: what winners of each kind of search found, by world."""
    parts = [TITLE, _INTRODUCTION]
    for title, worlds in searches.items():
        parts += [f"## {_first_large(title)}", "\n".join(f"- {line}" for line in in_short(worlds)), *_tables(worlds)]
    return "\n\n".join(parts) + "\n"


def in_short(worlds: Worlds) -> list[str]:
    """A few sentences over all worlds: reflexes kept and switched off, who acts, how packets travel."""
    lines = []
    shares = {world: reflex_shares(several) for world, several in worlds.items()}
    if any(shares.values()):
        by_rule = {text: {world: own[text] for world, own in shares.items() if text in own} for text in _texts(shares)}
        kept = [text for text, own in by_rule.items() if min(own.values()) >= _KEPT]
        lines.append(f"Kept as a reflex by three of four agents and more, everywhere: {_listed(kept)}.")
        off = sorted((text for text in by_rule if text not in kept), key=lambda text: min(by_rule[text].values()))
        told = "; ".join(f"{markdown_code(text)} {_from_to(by_rule[text], '{:.0%}')}" for text in off[:_MOST_OFF])
        if told:
            lines.append(f"Most often switched off, by the share of agents in which they are left: {told}.")
        own = {world: _mean(several, lambda one: one.by_reflex) for world, several in worlds.items()}
        lines.append(
            f"Of all that agents did, reflexes brought about {_from_to(own, '{:.0%}')}; what was learnt, the rest."
        )
    through = {world: mean for world, several in worlds.items() if (mean := _carriers(several)) is not None}
    if through:
        lines.append(f"A delivered packet passed through {_from_to(through, '{:.1f} agents')}.")
    return lines


def _tables(worlds: Worlds) -> list[str]:
    parts = []
    shares = {world: reflex_shares(several) for world, several in worlds.items()}
    if any(shares.values()):
        rows = [[markdown(text), *(_share(own.get(text)) for own in shares.values())] for text in _texts(shares)]
        parts += ["### The designer's rules: in how many agents they are reflexes", _table("rule", worlds, rows)]
    actions = {world: _actions(several) for world, several in worlds.items()}
    order = sorted(
        dict.fromkeys(text for own in actions.values() for text in own),
        key=lambda text: -sum(own.get(text, _NEVER)[0] for own in actions.values()),
    )
    rows = [
        [markdown(text), *("{:.0%} ({:.0%})".format(*own.get(text, _NEVER)) for own in actions.values())]
        for text in order[:_MOST_ACTIONS]
    ]
    parts += ["### What agents do: shares of all acts, in brackets those that no reflex brought about"]
    parts += [_table("action", worlds, rows)]
    parts += ["### Learned rules that set a world apart"]
    parts += [
        "Those that act more often here than in the mean of the other worlds (share of all acts; winners in which "
        "they act):"
        if len(worlds) > 1
        else "Those that act most (share of all acts; winners in which they act):"
    ]
    parts += ["\n".join(f"- {_first_large(world)}: {'; '.join(_own(world, worlds))}." for world in worlds)]
    parts += ["### How packets travel", _travel(worlds)]
    return parts


def _actions(several: Sequence[Findings]) -> dict[str, tuple[float, float]]:
    """By action, its mean share of all acts, and that of acts that no reflex brought about."""
    texts = dict.fromkeys(text for one in several for text in one.actions)
    means = {text: np.mean([one.actions.get(text, _NEVER) for one in several], axis=0) for text in texts}
    return {text: (float(mean[0]), float(mean[1])) for text, mean in means.items()}


def _own(world: str, worlds: Worlds) -> list[str]:
    others = Counter[str]()
    for name, several in worlds.items():
        if name != world:
            for text, share, _ in acting_shares(several):
                others[text] += share / (len(worlds) - 1)  # type: ignore[assignment]
    mine = sorted(acting_shares(worlds[world]), key=lambda found: others[found[0]] - found[1])
    of = len(worlds[world])
    return [f"{markdown_code(text)} ({share:.1%}; {count} of {of})" for text, share, count in mine[:_MOST_OWN]]


def _travel(worlds: Worlds) -> str:
    rows = []
    for world, several in worlds.items():
        delivered = [one.delivered for one in several if one.delivered is not None]
        carrying = [one.carrying for one in several if one.carrying is not None]
        figures = (
            np.mean(delivered) if delivered else None,
            _carriers(several),
            np.mean(carrying) if carrying else None,
        )
        told = ("-" if figure is None else f"{figure:.1f}" for figure in figures)
        rows.append([_first_large(world), str(len(several)), *told])
    names = "world", "winners", "packets delivered", "agents a packet passes through", "carrying is shared as if by"
    lines = [f"| {' | '.join(names)} |", "|---|" + "--:|" * (len(names) - 1)]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def _carriers(several: Sequence[Findings]) -> float | None:
    known = [one.carriers for one in several if one.carriers is not None]
    return float(np.mean(known)) if known else None


def _mean(several: Sequence[Findings], of: Callable[[Findings], float]) -> float:
    return float(np.mean([of(one) for one in several]))


def _table(first: str, worlds: Worlds, rows: Sequence[Sequence[str]]) -> str:
    head = [f"| {first} | " + " | ".join(markdown(world) for world in worlds) + " |", "|---|" + "--:|" * len(worlds)]
    return "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows)])


def _texts(shares: Mapping[str, Mapping[str, float]]) -> list[str]:
    return list(dict.fromkeys(text for own in shares.values() for text in own))


def _share(value: float | None) -> str:
    return "-" if value is None else f"{value:.0%}"


def _from_to(figures: Mapping[str, float], form: str) -> str:
    """The least and the greatest with their worlds."""
    low, high = min(figures, key=lambda world: figures[world]), max(figures, key=lambda world: figures[world])
    if low == high:
        return form.format(figures[low])
    return f"{form.format(figures[low])} ({markdown(low)}) to {form.format(figures[high])} ({markdown(high)})"


def _listed(texts: Sequence[str]) -> str:
    return "; ".join(map(markdown_code, texts)) or "none"


def _first_large(text: str) -> str:
    return markdown(text[:1].upper() + text[1:])
