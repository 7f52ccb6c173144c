"""The one place where something to deploy becomes a job for a rollout, and what came back becomes a deployment.

Whatever decides what agents do is deployed, evaluated and replayed alike: rule-sets, a solution of a search or of a
file, a decision list, a network, a user's own policy.
"""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Hashable
from typing import Any

import jax
import numpy as np

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.field import refuse, show
from slcs2_jax.grammar import Grammar, RuleSets, make_rule
from slcs2_jax.grammar.grammar import GRAMMARS
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.policy.bound import BoundPolicy, bind_list, bind_rules
from slcs2_jax.policy.decision_list import DecisionList
from slcs2_jax.results import SavedSolution
from slcs2_jax.results.figures import Figures
from slcs2_jax.rollout import Done, Job
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.keys import Key
from slcs2_jax.search.solution import Solution
from slcs2_jax.swarm.reward import Progress
from slcs2_jax.swarm.task import Delivery, Score
from slcs2_jax.world.scenario import Scenario

Deployable = RuleSets | Solution | SavedSolution | DecisionList | BoundPolicy
ACCEPTED = "a RuleSets, Solution, SavedSolution, DecisionList or BoundPolicy"


def bound(deployable: Deployable, settings: Settings, name: str = "policy") -> BoundPolicy:
    """A policy with its parameters, for swarms with these settings.

    Args:
        deployable: rule-sets or a search's solution, of the settings' grammar; a saved solution, which brings its own;
            a decision list, the same for every agent; or a policy that is bound already (`slcs2_jax.bind`).
        settings: sizes, and how rules are decoded.
        name: of the argument, for complaints.

    Raises:
        InputError: something else, of another size, or with rules that its grammar cannot say.
    """
    if isinstance(deployable, BoundPolicy):
        return deployable
    if isinstance(deployable, DecisionList):
        return bind_list(deployable, settings.swarm.agents)
    if isinstance(deployable, SavedSolution):
        deployable.check_fits(settings)
        return of_grammar(_grammar(settings, deployable.grammar_text), deployable.rules)
    if not isinstance(deployable, RuleSets | Solution):
        raise refuse(name, type(deployable).__name__, ACCEPTED)
    rules = deployable.rules if isinstance(deployable, Solution) else deployable
    size = (settings.swarm.agents, settings.rules.rules)
    if rules.action.shape != size:
        raise InputError(f"{name}: {list(rules.action.shape)} agents and rules; accepted are {list(size)}")
    return of_grammar(_grammar(settings), rules)


def _grammar(settings: Settings, text: str | None = None) -> Grammar:
    """Parsed once for all policies that have the same, as long as its file and the plug-ins are what they are."""
    name = settings.rules.grammar
    stamp = None
    if text is None and name not in GRAMMARS:
        with contextlib.suppress(OSError):
            stamp = os.stat(name).st_mtime_ns
    return _parsed(settings, text, Vocabulary.current(settings.radio.channels), stamp)


@functools.lru_cache(maxsize=16)
def _parsed(settings: Settings, text: str | None, vocabulary: Vocabulary, stamp: int | None) -> Grammar:
    return Grammar.of(settings, text)


def of_grammar(grammar: Grammar, rules: RuleSets) -> BoundPolicy:
    """Rule-sets under the classifier. Raises InputError naming a rule that the grammar cannot say."""
    if rules.vocabulary != grammar.vocabulary:
        raise InputError(
            f"rules: of another vocabulary than grammar={grammar.name}; accepted are rules of that grammar"
        )
    foreign = (rules.mask & ~_clauses_of(grammar)).any(axis=-1) | ~np.isin(rules.action, grammar.actions)
    if foreign.any():
        agent, index = (int(place) for place in np.argwhere(foreign)[0])
        raise InputError(f"rules: '{rules.text(agent, index)}' cannot be said in grammar={grammar.name}")
    return bind_rules(rules, grammar)


@functools.lru_cache(maxsize=16)
def _clauses_of(grammar: Grammar) -> Any:
    """A mask of every clause that a grammar knows."""
    return make_rule(grammar.clauses, grammar.actions[0], grammar.vocabulary).mask()


def rules_of(policy: BoundPolicy) -> int:
    """R, rules per agent; 0 for a policy without rules."""
    return policy.given.action.shape[1] if isinstance(policy.given, RuleSets) else 0


def program(policy: BoundPolicy) -> Hashable:
    """What policies must have in common to be computed by one program, whatever each of them can say."""
    arrays = policy.policy.arrays(policy.given, Language.whole(policy.language.vocabulary))
    leaves, structure = jax.tree.flatten(arrays)
    shapes = tuple((leaf.shape, str(leaf.dtype)) for leaf in leaves)
    return policy.policy, policy.language.vocabulary, structure, shapes


def joined(languages: list[Language]) -> Language:
    """What any of them can say; all are of one vocabulary."""
    vocabularies = {language.vocabulary for language in languages}
    if len(vocabularies) != 1:
        raise InputError("grammars of different vocabularies cannot share a batch; accepted are those of one")
    return Language(
        vocabularies.pop(),
        max(language.words for language in languages),
        tuple(sorted({clause for language in languages for clause in language.own_clauses})),
        tuple(sorted({action for language in languages for action in language.own_actions})),
    )


def job_of(policy: BoundPolicy, name: Hashable, scenario: Scenario, key: Key, settings: Settings) -> Job:
    """One deployment with the settings' physical values, for a rollout."""
    return Job(name, scenario, policy.channels, policy.given, key, settings)


def deployment_of(done: Done, packets: int, task: Delivery) -> Deployment:
    """What an episode with so many packets measured, with its fitness by the task.

    Raises InputError naming the task or the reward that gave what is no finite number.
    """
    score = Score(
        delivered=done.delivered,
        packets=packets,
        steps=done.steps,
        time_limit=done.job.scenario.time_limit,
        measures=done.measures,
    )
    fitness = task.fitness(score)
    if not isinstance(fitness, float | int) or not np.isfinite(fitness):
        raise InputError(f"task {type(task).__name__}: fitness is {show(fitness)}; accepted is a finite number")
    own = type(task.reward) is not Progress
    if own and done.figures is not None and not np.isfinite(done.figures.quality).all():
        raise InputError(f"reward {type(task.reward).__name__}: is not finite in every step; accepted is what is")
    return Deployment(
        fitness=float(fitness),
        delivered=done.delivered,
        steps=done.steps,
        contribution=done.contribution,
        figures=None if done.figures is None else Figures(**vars(done.figures)),
        measures=done.measures,
    )
