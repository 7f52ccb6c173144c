"""What is played: the same scenarios, rules and episode keys for everybody."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax.config import Compute, InputError, Settings, Swarm, World
from slcs2_jax.config.settings import Rules
from slcs2_jax.grammar import RuleSets, load_grammar, parse_grammar, random_rule_sets
from slcs2_jax.grammar.language import Language
from slcs2_jax.results import load_solution
from slcs2_jax.rollout import Job
from slcs2_jax.world.scenario import Scenario, make_scenario

SEEDS = 101  # scenarios of which the median is taken


@dataclass(frozen=True, eq=False)
class Workload:
    """An endless sequence of episodes that repeats its scenarios and rules, but never a key.

    Attributes:
        settings: physics and sizes.
        channels, language: what the grammar needs.
        scenarios, solutions: as many of both; episode i has those at i modulo their number.
    """

    settings: Settings
    channels: tuple[int, ...]
    language: Language
    scenarios: tuple[Scenario, ...]
    solutions: tuple[RuleSets, ...]

    def key(self, episode: int) -> tuple[np.uint32, np.uint32]:
        """The randomness of an episode."""
        first, second = np.random.SeedSequence([episode]).generate_state(2, np.uint32)
        return first, second

    def job(self, episode: int) -> Job:
        """An episode for the devices."""
        place = episode % len(self.scenarios)
        rules = self.solutions[place]
        return Job(episode, self.scenarios[place], self.channels, rules, self.key(episode))

    def cut(self, steps: int) -> Workload:
        """The first steps of every episode."""
        shorter = (dataclasses.replace(s, time_limit=min(s.time_limit, steps)) for s in self.scenarios)
        return dataclasses.replace(self, scenarios=tuple(shorter))


def settings_of(cell: str, *, agents: int = Swarm.agents, rules: int = Rules.rules, compute: Compute) -> Settings:
    """Settings of a cell such as urban/short, as the specification has them but for the sizes."""
    environment, _, far = cell.partition("/")
    return Settings(
        world=World.preset(environment, far), swarm=Swarm(agents=agents), rules=Rules(rules=rules), compute=compute
    )


def random_workload(settings: Settings, count: int, *, median: bool) -> Workload:
    """Random rules, the same for the same sizes; ``median``: all in the median scenario where there are buildings."""
    named = settings.rules
    grammar = load_grammar(named.grammar)
    solutions = (
        random_rule_sets(grammar, settings.swarm.agents, named.rules, np.random.default_rng([named.rules, i]))
        for i in range(count)
    )
    return Workload(
        settings=settings,
        channels=grammar.channels_used,
        language=Language.of([grammar]),
        scenarios=_scenarios(settings, count, median),
        solutions=tuple(solutions),
    )


def saved_workload(settings: Settings, path: Path, count: int, *, median: bool) -> Workload:
    """The rules of a saved solution in every episode; agents and rules become its own."""
    saved = load_solution(path)
    agents, rules = saved.rules.action.shape
    evolved = saved.settings.rules
    grammar = parse_grammar(
        saved.grammar_text,
        name=evolved.grammar,
        max_clauses=evolved.max_clauses,
        single_option_consumes=evolved.single_option_consumes,
    )
    sizes: dict[str, Any] = {
        "swarm": dataclasses.replace(settings.swarm, agents=agents),
        "rules": dataclasses.replace(settings.rules, rules=rules),
    }
    settings = dataclasses.replace(settings, **sizes)
    return Workload(
        settings=settings,
        channels=grammar.channels_used,
        language=Language.of([grammar]),
        scenarios=_scenarios(settings, count, median),
        solutions=(saved.rules,) * count,
    )


def _scenarios(settings: Settings, count: int, median: bool) -> tuple[Scenario, ...]:
    if median and settings.world.buildings:
        return (median_scenario(settings),) * count
    return tuple(make_scenario(settings, seed) for seed in range(count))


def median_scenario(settings: Settings) -> Scenario:
    """The one with the median number of walls among the scenarios of seeds 0..100."""
    found = sorted((make_scenario(settings, seed) for seed in range(SEEDS)), key=lambda one: one.walls)
    return found[SEEDS // 2]


def with_walls(settings: Settings, walls: int) -> Scenario:
    """A scenario with exactly so many walls: of the first seed that has enough, the others taken away at random.

    Raises InputError if none of the seeds 0..100 has enough.
    """
    for seed in range(SEEDS):
        scenario = make_scenario(settings, seed)
        if scenario.walls >= walls:
            stay = np.sort(np.random.default_rng(seed).permutation(scenario.walls)[:walls])
            first = len(scenario.vertical)
            return dataclasses.replace(
                scenario,
                vertical=scenario.vertical[stay[stay < first]],
                horizontal=scenario.horizontal[stay[stay >= first] - first],
            )
    raise InputError(f"walls={walls}: accepted is what one of the scenarios of seeds 0..{SEEDS - 1} has")
