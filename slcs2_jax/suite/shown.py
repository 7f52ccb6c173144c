"""What the page shows of the best entry of each field in each kind of world: a replay, and what its rules say."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax.config import Compute
from slcs2_jax.grammar import RuleSets
from slcs2_jax.looking.page_replay import pack_replay
from slcs2_jax.looking.recording import NOBODY, Recording
from slcs2_jax.looking.solutions import replay
from slcs2_jax.running.deployable import bound
from slcs2_jax.suite.deployed import ready
from slcs2_jax.suite.entries import shipped
from slcs2_jax.suite.table import Table

MOST_RULES = 8  # that are said in words


def best_of_fields(table: Table) -> list[tuple[str, str]]:
    """World and entry: in each kind of world the fittest of each field, of the suite's own entries."""
    found = []
    for world in table.worlds:
        here = [name for name in table.entries if name in shipped() and (name, world.name) in table.results]
        fields = dict.fromkeys(shipped()[name].field for name in here)
        for field in fields:
            of = [name for name in here if shipped()[name].field == field]
            found.append((world.name, max(of, key=lambda name: float(table.scores(name, world.name).mean()))))
    return found


def shown(table: Table, roots: Sequence[Path], compute: Compute) -> Iterator[tuple[dict[str, Any], bytes]]:
    """Of each of those its facts, and the packed replay of the first deployment in the first test world.

    Raises InputError for an artefact that is not there or damaged.
    """
    for name, who in best_of_fields(table):
        world, entry = table.suite.worlds[name], shipped()[who]
        seed = world.seeds_of("test")[0]
        deployed = ready(entry, world, seed, roots, (0,))
        settings = dataclasses.replace(deployed.settings, compute=compute)
        [policy] = deployed.policies
        recording = replay(policy, settings, seed=seed)
        rules = bound(policy, settings).given
        facts = {
            "world": world.title,
            "field": entry.field,
            "entry": entry.title,
            "fitness": float(table.scores(who, name).mean()),
            "of": f"{entry.title} in the first test world of {world.title}, seed {seed}",
            "rules": _texts(rules) if isinstance(rules, RuleSets) else None,
            "says": _says(recording, rules) if isinstance(rules, RuleSets) else [],
        }
        yield facts, pack_replay(recording)


def _texts(rules: RuleSets) -> dict[str, Any]:
    """Every agent's rules in words, each text once, as the replay's program reads them."""
    agents, count = rules.action.shape
    places: dict[str, int] = {}
    which = [
        places.setdefault(rules.text(agent, rule), len(places)) for agent in range(agents) for rule in range(count)
    ]
    return {"rules": count, "texts": list(places), "text": which}


def _says(recording: Recording, rules: RuleSets) -> list[tuple[str, float]]:
    """The rules that acted most often, in words, with the share of all the times that any did."""
    counts: dict[str, int] = {}
    for agent in range(recording.agents):
        chosen, times = np.unique(recording.rule[:, agent], return_counts=True)
        for rule, often in zip(chosen.tolist(), times.tolist(), strict=True):
            if rule != NOBODY:
                text = rules.text(agent, rule)
                counts[text] = counts.get(text, 0) + often
    total = max(1, sum(counts.values()))
    ranked = sorted(counts, key=lambda text: (-counts[text], text))
    return [(text, counts[text] / total) for text in ranked[:MOST_RULES]]
