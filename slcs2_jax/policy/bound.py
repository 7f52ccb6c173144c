"""A policy with its parameters, ready to be deployed: rule-sets, decision lists, networks and users' own alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.registry import KINDS
from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.language import Language, Sayer
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.policy.decision_list import DecisionList
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.policy.policy import Policy
from slcs2_jax.results.policy_file import load_policy


@dataclasses.dataclass(frozen=True, eq=False)
class BoundPolicy:
    """What is deployed.

    Attributes:
        policy: the code.
        given: its parameters: rule-sets, or any pytree of NumPy arrays; `policy.arrays` lays them out.
        language: what its agents can say and do.
        channels: indices of the channels that it uses.
    """

    policy: Policy
    given: Any
    language: Language
    channels: tuple[int, ...]


def bind_rules(rules: RuleSets, sayer: Sayer | None = None, policy: Policy | None = None) -> BoundPolicy:
    """Rule-sets under the classifier, or another policy that is made of rules.

    sayer: the grammar that they come from, if that is known: all its solutions have the same sizes then.
    """
    language = Language.whole(rules.vocabulary) if sayer is None else Language.of([sayer])
    channels = rules.channels_used if sayer is None else sayer.channels_used
    return BoundPolicy(policy or Classifier(), rules, language, channels)


def bind_list(decisions: DecisionList, agents: int) -> BoundPolicy:
    """The same decision list for each of so many agents."""
    return bind_rules(decisions.rule_sets(agents), decisions, FirstMatch())


def bind(policy: Policy | str, given: Any) -> BoundPolicy:
    """A policy of another kind, or the one registered under a name, with its parameters.

    given: rule-sets, or any pytree of arrays.

    Raises InputError for a name that is none, or something that is no policy.
    """
    if isinstance(policy, str):
        part = KINDS["policy"].get(policy)
        policy = part.of(given) if isinstance(part, type) and issubclass(part, Policy) else part()
    if not isinstance(policy, Policy):
        raise InputError(f"policy: {type(policy).__name__}; accepted is a Policy or the name of one")
    if isinstance(given, RuleSets):
        return bind_rules(given, policy=policy)
    language = getattr(policy, "language", None) or Language.whole(Vocabulary.current())
    return BoundPolicy(policy, jax.tree.map(np.asarray, given), language, policy.channels)


def load_bound(path: str | Path) -> tuple[BoundPolicy, Mapping[str, Any]]:
    """The policy of a file of `save_policy`, and the remarks in it.

    Raises InputError naming the file if it is none or damaged, or holds what its policy does not take.
    """
    saved = load_policy(path)
    try:
        return bind(saved.name, saved.given), saved.about
    except InputError as error:
        raise InputError(f"policy={path}: {error}") from None
