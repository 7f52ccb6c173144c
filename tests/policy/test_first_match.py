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
from slcs2_jax.grammar.vocabulary import MASK_WORDS, NO_ACTION
from slcs2_jax.policy import classifier
from slcs2_jax.policy import decision_list as designed
from slcs2_jax.policy.classifier import Rules
from slcs2_jax.policy.decision_list import load_decision_list, parse_decision_list
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.search import fresh_deployment_key
from slcs2_jax.world.arena import stack
from slcs2_jax.world.scenario import make_scenario

R, N, B = 7, 3, 50
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
    truth = rng.integers(0, 8, (MASK_WORDS, N, B)).astype(np.uint32)
    rules = Rules(jnp.asarray(mask), jnp.asarray(action))
    memory = designed.initial_memory(rules, LEARNING)
    decide = jax.jit(designed.decide)
    for _ in range(2):
        memory, chosen = decide(memory, rules, jnp.asarray(truth), None, None, None, LEARNING)
    usage = np.zeros((R, N, B), int)
    for i in range(N):
        for b in range(B):
            place, expected = first_that_holds(mask[:, :, i, b].T, action[:, i, b], truth[:words, i, b])
            assert chosen[i, b] == expected
            if place is not None:
                usage[place, i, b] = 2
    assert chosen.dtype == jnp.int32
    assert (chosen == NO_ACTION).any()
    np.testing.assert_array_equal(memory.usage, usage)
    assert (usage[1:] > 0).any()


def test_nothing_is_learnt():
    rules = Rules(jnp.ones((3, R, N), jnp.uint32), jnp.zeros((R, N), jnp.uint8))
    memory = designed.initial_memory(rules, LEARNING)
    after = designed.settle(
        designed.remember(memory, jnp.ones(N)), designed.gain(jnp.ones(N), jnp.ones(N, bool)), LEARNING
    )
    figures = designed.finish(after, jnp.float32(1), LEARNING)
    for name in ("quality", "strength", "error", "usage"):
        assert getattr(figures, name).shape == (R, N)
        assert not getattr(figures, name).any()


def play(controller, rule_sets, channels=(0,), seed=1):
    """One whole episode of the small world; its Result."""
    scenario = make_scenario(SMALL, seed)
    arena = jax.tree.map(jnp.asarray, stack([scenario], [channels], capacity=(0, 0), width=1))
    rules = Rules(jnp.asarray(rule_sets.mask.transpose(2, 1, 0)[..., None]), jnp.asarray(rule_sets.action.T[..., None]))
    key = jnp.asarray(np.array(fresh_deployment_key(seed, 0), np.uint32)[:, None])
    parameters = Parameters.of(SMALL, controller)

    @jax.jit
    def whole(arena, rules, key, parameters):
        episode = episodes.begin(arena, rules, key, parameters)
        return episodes.result(episodes.advance(episode, parameters, scenario.time_limit // 10), parameters)

    return jax.device_get(whole(arena, rules, key, parameters))


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
    result = play(designed, chain.rule_sets(5))
    assert result.delivered == [10]
    assert result.steps < 1500
    assert (result.contribution > 0).any()
    assert (result.usage.sum(axis=0) <= result.steps).all()
    assert not result.quality.any()


def test_the_bundled_behaviour_delivers():
    result = play(designed, load_decision_list("designed").rule_sets(5))
    assert result.delivered == [10]


@dataclasses.dataclass(frozen=True)
class Idle:
    """A controller of one's own, an object: never does anything, and keeps count of the steps."""

    def initial_memory(self, rules, learning):
        return jnp.zeros(rules.action.shape, jnp.int32)

    def decide(self, memory, rules, truth, key, t, share, learning):
        return memory + 1, jnp.full(memory.shape[1:], NO_ACTION, jnp.int32)

    def remember(self, memory, reward):
        return memory

    def gain(self, reward, acts):
        return None

    def settle(self, memory, gains, learning):
        return memory

    def finish(self, memory, share, learning):
        none = jnp.zeros(memory.shape)
        return types.SimpleNamespace(quality=none, strength=none, error=none, usage=memory)


def test_controllers_are_interchangeable():
    rule_sets = random_rule_sets(load_grammar("main"), agents=5, rules=30, rng=np.random.default_rng(0))
    plain = play(classifier, rule_sets)
    assert plain.usage.any()
    # the same functions, handed over otherwise
    module = types.ModuleType("wrapped")
    for name in ("initial_memory", "decide", "remember", "gain", "settle", "finish"):
        setattr(module, name, getattr(classifier, name))
    wrapped = play(module, rule_sets)
    for name, value in dataclasses.asdict(plain).items():
        np.testing.assert_array_equal(getattr(wrapped, name), value)
    idle = play(Idle(), rule_sets)
    assert idle.delivered == [0]
    assert (idle.usage == idle.steps).all()
    assert (idle.steps == 1500).all()
