"""A new solution from a parent: crossover and mutation of low-quality rule-sets (paper, Rule-Set Evolution).

[n, R] = agents, rules; L = rule-sets that evolve. Each of them becomes, in this order,
  varpi     of its own rules, lowest error first (used before unused, then by index),
  varsigma  rules of one donor, greatest strength first (then by index),
  the rest  new random rules,
and every other rule-set is passed on as it is. Where the designer's rules stand in the first K places, all of this is
about the R - K behind them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from slcs2_jax.grammar.ruleset import rule_ids
from slcs2_jax.search.evaluation import Evaluation
from slcs2_jax.search.inheritance import learnt_quality, with_fresh
from slcs2_jax.search.member import Member
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.solution import ORIGIN, Origin, Solution
from slcs2_jax.search.supply import RuleSupply

# A product that is a whole number on paper, as 100 * 0.58 / 2, can fall short of it by one rounding error.
_ROUNDING = 1e-9


def low_quality(contribution: np.ndarray) -> np.ndarray:
    """bool[n]: agents whose contribution int[n] is below the mean; all of them if all contribute the same.

    That exception deviates from the paper: nobody would evolve, usually because nothing is delivered yet.
    """
    low = contribution * contribution.size < contribution.sum()
    return low if low.any() else np.ones_like(low)


def donor_weights(contribution: np.ndarray, receivers: np.ndarray) -> np.ndarray:
    """int[L, n] proportions in which each receiver (agent number, int[L]) draws its donor.

    An agent weighs its contribution if that is at least the mean, and never gives to itself (it could only where all
    contribute the same). All weights are 0 where nothing was contributed: there is no donor then.
    """
    high = contribution * contribution.size >= contribution.sum()
    weights = np.tile(np.where(high, contribution, 0), (receivers.size, 1))
    weights[np.arange(receivers.size), receivers] = 0
    return weights


def kept_count(rules: int, fitness: float, explorations: int, varrho: float) -> int:
    """varpi = floor(R clip(fit / 2 - phi / varrho, 0, 1)), phi counted before this attempt.

    The paper prints max(1, .) in place of the clip: that would leave no room for any change.
    """
    share = min(1.0, max(0.0, fitness / 2 - explorations / varrho))
    return math.floor(rules * share + _ROUNDING)


def lowest_error(error: np.ndarray, used: np.ndarray) -> np.ndarray:
    """int[..., R] rule indices: used rules before unused ones, within both by error, ties by index."""
    return np.lexsort((error, ~used), axis=-1)


def greatest_strength(strength: np.ndarray) -> np.ndarray:
    """int[..., R] rule indices by falling strength, ties by index."""
    return np.argsort(-strength, axis=-1, kind="stable")


def draw_exchange(
    contribution: np.ndarray, receivers: np.ndarray, remaining: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Donor int[L] and varsigma int[L] of each receiver: varsigma = floor((R - varpi) U(0, 1)), remaining = R - varpi.

    The uniform numbers are drawn first, then the donors; without a donor varsigma is 0.
    """
    weights = donor_weights(contribution, receivers)
    if not weights.any():
        return receivers, np.zeros(receivers.size, np.int64)
    count = np.floor(remaining * rng.random(receivers.size)).astype(np.int64)
    ends = np.cumsum(weights, axis=1)
    pick = rng.integers(0, ends[:, -1])
    return (ends <= pick[:, None]).sum(axis=1), count


class Exchange:
    """The paper's variation: `offspring` with `search.varrho`, and with `exchange` or without."""

    def __init__(self, problem: Problem) -> None:
        self._varrho, self._exchange = problem.settings.varrho, problem.settings.exchange
        self._places, self._initial = problem.places, problem.initial_quality
        self._inherit, self._distinct = problem.settings.inherit_quality, problem.distinct

    def __call__(
        self,
        parent: Solution,
        evaluation: Evaluation,
        *,
        explorations: int,
        generation: int,
        members: Sequence[Member],
        supply: RuleSupply,
        rng: np.random.Generator,
    ) -> Solution:
        """See `Variation`."""
        return offspring(
            parent,
            evaluation,
            explorations=explorations,
            generation=generation,
            varrho=self._varrho,
            exchange=self._exchange,
            supply=supply,
            rng=rng,
            places=self._places,
            initial_quality=self._initial if self._inherit else None,
            distinct=self._distinct,
        )


def offspring(
    parent: Solution,
    evaluation: Evaluation,
    *,
    explorations: int,
    generation: int,
    varrho: float,
    exchange: bool,
    supply: RuleSupply,
    rng: np.random.Generator,
    places: int = 0,
    initial_quality: float | None = None,
    distinct: bool = False,
) -> Solution:
    """The child of `parent`, born in `generation`; `explorations` = phi of the parent before this attempt.

    Without `exchange` nothing is copied (varsigma = 0). `rng` draws donors and shares, `supply` gives the new rules.
    The first `places` rules of every rule-set stay, with their reflexes. With `initial_quality`, that of rules that
    inherited none, the child inherits what was learnt (`inheritance`); otherwise it has no quality of its own.
    With `distinct` no new rule is one that its agent has already.
    """
    rules = parent.shape[1] - places
    receivers = np.flatnonzero(low_quality(evaluation.contribution_sum))
    kept = kept_count(rules, evaluation.fitness, explorations, varrho)
    donors, copied = receivers, np.zeros(receivers.size, np.int64)
    if exchange:
        donors, copied = draw_exchange(evaluation.contribution_sum, receivers, rules - kept, rng)
    from_agent, from_rule, is_copied, is_new = _sources(evaluation, receivers, donors, copied, kept, places)

    given = parent.arrays()
    names = ("mask", "action", *ORIGIN, *(["reflex"] if "reflex" in given else []))
    arrays = {name: given[name][from_agent, from_rule] for name in names}
    _fill(arrays, is_new, supply, distinct)
    if initial_quality is not None:
        learnt = learnt_quality(parent.rules, evaluation, initial_quality)
        arrays["quality"] = with_fresh(learnt[from_agent, from_rule], is_new, learnt)
    arrays["origin_kind"][is_copied], arrays["origin_kind"][is_new] = Origin.COPIED, Origin.RANDOM
    arrays["origin_generation"][is_copied | is_new] = generation
    arrays["origin_agent"][is_copied], arrays["origin_agent"][is_new] = from_agent[is_copied], -1
    child = {"generation": generation, "parent": parent.generation}
    return Solution.of(arrays | child, parent.rules.vocabulary)


def _fill(arrays: dict[str, np.ndarray], is_new: np.ndarray, supply: RuleSupply, distinct: bool) -> None:
    """Put new random rules into the places bool[n, R]."""
    if not distinct:
        for name, array in supply.take(int(is_new.sum())).items():
            arrays[name][is_new] = array
        return
    ids = rule_ids(arrays["mask"], arrays["action"])
    for agent in np.flatnonzero(is_new.any(axis=1)).tolist():
        places = is_new[agent]
        for name, array in supply.take_distinct(int(places.sum()), {*ids[agent, ~places].tolist()}).items():
            arrays[name][agent, places] = array


def _sources(
    evaluation: Evaluation, receivers: np.ndarray, donors: np.ndarray, copied: np.ndarray, kept: int, places: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where each rule of the child comes from: agent and rule of the parent, int[n, R] (of a new rule they mean
    nothing); which are copied, and which are new, bool[n, R]."""
    figures = evaluation.figures
    agents, rules = figures.shape
    first = places + kept
    from_agent = np.repeat(np.arange(agents), rules).reshape(agents, rules)
    from_rule = np.tile(np.arange(rules), (agents, 1))
    error, used = figures.error[receivers, places:], evaluation.used[receivers, places:]
    from_rule[receivers, places:first] = places + lowest_error(error, used)[:, :kept]
    taken = np.arange(rules - first) < copied[:, None]  # [L, R - K - varpi]
    best = places + greatest_strength(figures.strength[donors, places:])[:, : rules - first]
    is_copied, is_new = np.zeros((2, agents, rules), bool)
    is_copied[receivers, first:] = taken
    is_new[receivers, first:] = ~taken
    from_agent[is_copied] = np.repeat(donors, copied)
    from_rule[is_copied] = best[taken]
    return from_agent, from_rule, is_copied, is_new
