"""If-then-else over the vocabulary: against a plain loop, and a whole swarm that delivers."""

from __future__ import annotations

import dataclasses
import types

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax import episode as episodes
from slcs2_jax.config import Learning, Settings, Swarm, World
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar import load_grammar, random_rule_sets
from slcs2_jax.grammar.vocabulary import NO_ACTION, PAPER
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.policy.decision_list import load_decision_list, parse_decision_list
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.policy import Figures, Policy
from slcs2_jax.policy.rules import Rules
from slcs2_jax.search import fresh_deployment_key
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.world.arena import stack
from slcs2_jax.world.scenario import make_scenario

R, N, B = 7, 3, 50
DESIGNED = FirstMatch()
LEARNING = LearningParameters.of(Learning())
SMALL = Settings(world=World(distance=300.0, time_limit=1500), swarm=Swarm(agents=5, packets=10))


def first_that_holds(masks, actions, truth):
    """One agent: masks and truth are lists of words; the place and the action of the first rule that holds."""
    for place, (mask, action) in enumerate(zip(masks, actions, strict=True)):
        if all(int(word) & ~int(true) == 0 for word, true in zip(mask, truth, strict=True)):
            return place, int(action)
    return None, NO_ACTION


@pytest.mark.parametrize("words", [3, 4])
def test_the_first_rule_that_holds_acts(words):
    rng = np.random.default_rng(words)
    mask = np.zeros((words, R, N, B), np.uint32)
    np.put_along_axis(
        mask, rng.integers(0, words, (2, R, N, B)), (1 << rng.integers(0, 3, (2, R, N, B))).astype(np.uint32), 0
    )
    action = rng.integers(0, 57, (R, N, B)).astype(np.uint8)
    truth = rng.integers(0, 8, (PAPER.words, N, B)).astype(np.uint32)
    rules = Rules(jnp.asarray(mask), jnp.asarray(action))
    memory = DESIGNED.initial_memory(rules, jnp.zeros((N, B)), LEARNING)
    decide = jax.jit(DESIGNED.decide)
    seen = Observation(jnp.asarray(truth), None)
    for _ in range(2):
        memory, chosen = decide(memory, rules, seen, None, LEARNING)
    rule = DESIGNED.chosen(memory, rules, seen, None, LEARNING)
    matched = DESIGNED.matched(rules, seen)
    usage = np.zeros((R, N, B), int)
    for i in range(N):
        for b in range(B):
            place, expected = first_that_holds(mask[:, :, i, b].T, action[:, i, b], truth[:words, i, b])
            assert chosen[i, b] == expected
            assert rule[i, b] == (-1 if place is None else place)
            assert matched[:, i, b].any() == (place is not None)
            if place is not None:
                usage[place, i, b] = 2
    assert chosen.dtype == jnp.int32
    assert (chosen == NO_ACTION).any()
    np.testing.assert_array_equal(DESIGNED.finish(memory, None, LEARNING).usage, usage)
    assert (usage[1:] > 0).any()


def test_nothing_is_learnt():
    rules = Rules(jnp.ones((3, R, N), jnp.uint32), jnp.zeros((R, N), jnp.uint8))
    memory = DESIGNED.initial_memory(rules, jnp.zeros(N), LEARNING)
    after = DESIGNED.remember(memory, jnp.ones(N))
    after = DESIGNED.settle(after, DESIGNED.keep(after, jnp.ones(N), jnp.ones(N, bool)), LEARNING)
    figures = DESIGNED.finish(after, jnp.float32(1), LEARNING)
    for name in ("quality", "strength", "error", "usage"):
        assert getattr(figures, name).shape == (R, N)
        assert not getattr(figures, name).any()


def play(policy, rule_sets, channels=(0,), seed=1):
    """One whole episode of the small world; its Result."""
    scenario = make_scenario(SMALL, seed)
    arena = jax.tree.map(jnp.asarray, stack([scenario], [channels], capacity=(0, 0), width=1))
    parameters = Parameters.of(SMALL, policy)
    arrays = policy.arrays(rule_sets, parameters.physics.language)
    given = jax.tree.map(lambda leaf: jnp.asarray(leaf[..., None]), arrays)
    key = jnp.asarray(np.array(fresh_deployment_key(seed, 0), np.uint32)[:, None])

    @jax.jit
    def whole(arena, given, key, parameters):
        episode = episodes.begin(arena, given, key, parameters)
        return episodes.result(episodes.advance(episode, parameters, scenario.time_limit // 10), parameters)

    return jax.device_get(whole(arena, given, key, parameters))


def test_a_chain_of_relays_delivers():
    chain = parse_decision_list(
        """
        d_source < d_th => move toward sink
        packet held & d_si < net => send to si
        no packet held & NI <= P_rs & d_source < net & d_so = d_si => collect from source
        d_so < d_si => move toward si
        d_so > d_si => move toward so
        """
    )
    result = play(DESIGNED, chain.rule_sets(5))
    assert result.delivered == [10]
    assert result.steps < 1500
    assert (result.contribution > 0).any()
    assert (result.figures.usage.sum(axis=0) <= result.steps).all()
    assert not result.figures.quality.any()


def test_the_bundled_list_delivers():
    result = play(DESIGNED, load_decision_list("designed").rule_sets(5))
    assert result.delivered == [10]


@dataclasses.dataclass(frozen=True)
class Idle(Policy):
    """A policy of one's own without rules: never does anything, and keeps count of the steps."""

    def initial_memory(self, parameters, agents, learning):
        return jnp.zeros(agents.shape, jnp.int32)

    def decide(self, memory, parameters, seen, clock, learning):
        return memory + 1, jnp.full(memory.shape, NO_ACTION, jnp.int32)


@dataclasses.dataclass(frozen=True)
class Watched(Idle):
    """The same, which tells its count as a rule's usage."""

    def finish(self, memory, last_share, learning):
        none = jnp.zeros((1, *memory.shape))
        return Figures(quality=none, strength=none, error=none, usage=memory[None])


@dataclasses.dataclass(frozen=True)
class Wrapped(Policy):
    """The same methods as another policy's, handed over otherwise."""

    inner: Policy

    def arrays(self, *arguments):
        return self.inner.arrays(*arguments)

    def initial_memory(self, *arguments):
        return self.inner.initial_memory(*arguments)

    def decide(self, *arguments):
        return self.inner.decide(*arguments)

    def remember(self, *arguments):
        return self.inner.remember(*arguments)

    def keep(self, *arguments):
        return self.inner.keep(*arguments)

    def settle(self, *arguments):
        return self.inner.settle(*arguments)

    def finish(self, *arguments):
        return self.inner.finish(*arguments)


def test_policies_are_interchangeable():
    rule_sets = random_rule_sets(load_grammar("main"), agents=5, rules=30, rng=np.random.default_rng(0))
    plain = play(Classifier(), rule_sets)
    assert plain.figures.usage.any()
    wrapped = play(Wrapped(Classifier()), rule_sets)
    jax.tree.map(np.testing.assert_array_equal, wrapped, plain)
    nothing = np.zeros(3, np.float32)
    idle = play(Watched(), nothing)
    assert idle.delivered == [0]
    assert (idle.figures.usage == idle.steps).all()
    assert (idle.steps == 1500).all()


def test_a_policy_without_rules_has_no_figures_and_says_so_to_those_who_look_on():
    result = play(Idle(), np.zeros(3, np.float32))
    assert result.figures is None
    assert result.steps == [1500]
    view = types.SimpleNamespace(x=jnp.zeros((4, 2)))
    seen = Observation(None, view)
    assert (Idle().chosen(None, None, seen, None, LEARNING) == -1).all()
    assert Idle().matched(None, seen).shape == (0, 4, 2)
