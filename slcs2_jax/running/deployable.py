"""The one place where something to deploy becomes a job for a rollout, and what came back becomes a deployment.

Whatever decides what agents do is deployed, evaluated and replayed alike: rule-sets, a solution of a search or of a
file, a decision list.
"""

from __future__ import annotations

import functools
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.field import refuse
from slcs2_jax.grammar import Grammar, RuleSets, make_rule
from slcs2_jax.policy import classifier, decision_list
from slcs2_jax.policy.decision_text import Behaviour
from slcs2_jax.policy.protocol import Controller
from slcs2_jax.results import SavedSolution
from slcs2_jax.results.figures import FIGURES, Figures
from slcs2_jax.rollout import Done, Job
from slcs2_jax.search.evaluation import Deployment, fitness_of
from slcs2_jax.search.keys import Key
from slcs2_jax.search.solution import Solution
from slcs2_jax.world.scenario import Scenario

Policy = RuleSets | Solution | SavedSolution | Behaviour


@dataclass(frozen=True, eq=False)
class Deployable:
    """A policy ready to be deployed.

    Attributes:
        rules: of every agent, [n, R].
        controller: what the agents do with them.
        words: words of 32 clauses that their conditions can need.
        channels: indices of the channels that they can name.
    """

    rules: RuleSets
    controller: Controller
    words: int
    channels: tuple[int, ...]

    @property
    def size(self) -> int:
        """R, rules per agent."""
        return self.rules.action.shape[1]

    def job(self, name: Hashable, scenario: Scenario, key: Key) -> Job:
        """One deployment, for a rollout."""
        return Job(name, scenario, self.channels, self.rules.mask, self.rules.action, key)


def of_grammar(grammar: Grammar, rules: RuleSets) -> Deployable:
    """Rule-sets to learn with. Raises InputError naming a rule that the grammar cannot say."""
    known = make_rule(grammar.clauses, grammar.actions[0]).mask()
    foreign = (rules.mask & ~known).any(axis=-1) | ~np.isin(rules.action, grammar.actions)
    if foreign.any():
        agent, index = (int(place) for place in np.argwhere(foreign)[0])
        raise InputError(f"rules: '{rules.text(agent, index)}' cannot be said in grammar={grammar.name}")
    return Deployable(rules, classifier, grammar.words, grammar.channels_used)


def deployable(policy: Policy | Deployable, settings: Settings, name: str = "policy") -> Deployable:
    """Make a policy ready for deployment in swarms with these settings.

    Args:
        policy: rule-sets or a search's solution, of the settings' grammar; a saved solution, which brings its own; or a
            decision list, the same for every agent.
        settings: sizes, and how rules are decoded.
        name: of the argument, for complaints.

    Raises:
        InputError: something else, of another size, or with rules that its grammar cannot say.
    """
    if isinstance(policy, Deployable):
        return policy
    if isinstance(policy, Behaviour):
        rules = policy.rule_sets(settings.swarm.agents)
        return Deployable(rules, decision_list, policy.words, policy.channels_used)
    if isinstance(policy, SavedSolution):
        policy.check_fits(settings)
        return of_grammar(_grammar(settings, policy.grammar_text), policy.rules)
    if not isinstance(policy, RuleSets | Solution):
        raise refuse(name, type(policy).__name__, "a RuleSets, Solution, SavedSolution or Behaviour")
    rules = policy.rules if isinstance(policy, Solution) else policy
    size = (settings.swarm.agents, settings.rules.rules)
    if rules.action.shape != size:
        raise InputError(f"{name}: {list(rules.action.shape)} agents and rules; accepted are {list(size)}")
    return of_grammar(_grammar(settings, None), rules)


@functools.lru_cache(maxsize=16)
def _parsed(rules: object, text: str | None) -> Grammar:
    return Grammar.of(rules, text)  # type: ignore[arg-type]


def _grammar(settings: Settings, text: str | None) -> Grammar:
    """Parsed once for all solutions that have the same; a file, which may change, is read each time."""
    return Grammar.of(settings.rules) if text is None else _parsed(settings.rules, text)


def deployment_of(done: Done, packets: int) -> Deployment:
    """What an episode with so many packets measured."""
    return Deployment(
        fitness=fitness_of(
            delivered=done.delivered, packets=packets, steps=done.steps, time_limit=done.job.scenario.time_limit
        ),
        delivered=done.delivered,
        steps=done.steps,
        contribution=done.contribution,
        figures=Figures(**{name: getattr(done, name) for name in FIGURES}),
    )
