"""An agent's whole control against a plain Python agent: match, learn, choose, remember."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import Learning
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.policy import strength
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.policy.learning import LearningParameters
from slcs2_jax.policy.policy import Clock
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm.observation import Observation

R, N, STEPS, PERIOD, LIMIT = 12, 3, 60, 10, 100
CLASSIFIER = Classifier()


def start(rules, parameters):
    return CLASSIFIER.initial_memory(rules, jnp.zeros(N), parameters)


def decide(memory, rules, truth, key, t, share, parameters):
    seen = Observation(truth, None)  # it looks at nothing but the clauses
    return CLASSIFIER.decide(memory, rules, seen, Clock(key, t, share), parameters)


@functools.partial(jax.jit, static_argnames="period")
def live(rules, truths, rewards, key, parameters, period):
    """Drive the classifier through given observations and rewards; actions [STEPS, n] and the final memory."""
    memory = start(rules, parameters)

    def one_step(memory, given):
        t, truth, reward = given
        share = jnp.maximum(t - 1, 0).astype(jnp.float32) / np.float32(LIMIT)
        memory, action = decide(memory, rules, truth, key, t, share, parameters)
        memory = CLASSIFIER.remember(memory, reward)
        return memory, (action, CLASSIFIER.keep(memory, reward, action != NO_ACTION), memory.quality)

    def one_round(memory, given):
        memory, (action, kept, quality) = jax.lax.scan(one_step, memory, given)
        return CLASSIFIER.settle(memory, kept, parameters), (action, quality)

    length = strength.round_length(period, parameters.bp_max)
    given = (jnp.arange(STEPS, dtype=jnp.int32), truths, rewards)
    rounds = jax.tree.map(lambda a: a.reshape(STEPS // length, length, *a.shape[1:]), given)
    memory, told = jax.lax.scan(one_round, memory, rounds)
    action, quality = jax.tree.map(lambda a: a.reshape(STEPS, *a.shape[2:]), told)
    return action, quality, CLASSIFIER.finish(memory, jnp.float32((STEPS - 1) / LIMIT), parameters)


def plain(masks, actions, truths, rewards, chosen, learning):
    """One agent in plain Python, made to choose as recorded after checking that it may."""
    quality, error, total = np.zeros(R), np.zeros(R), np.zeros(R)
    usage, past, last = np.zeros(R, int), [], None
    history = []
    final = learning.alpha_q if learning.alpha_q_final is None else learning.alpha_q_final

    def learn(match, t):
        members, reward = last
        alpha = learning.alpha_q + (final - learning.alpha_q) * t / LIMIT
        ahead = quality[match].max() if match.any() else 0.0
        e = (1 - alpha) * error + alpha * abs(reward - quality)
        q = (1 - alpha) * quality + alpha * (reward + learning.beta_q * ahead)
        return np.where(members, q, quality), np.where(members, e, error)

    for t in range(STEPS):
        match = np.array([not any(m & ~w for m, w in zip(mask, truths[t], strict=True)) for mask in masks])
        if last is not None:
            quality, error = learn(match, t - 1)
        history.append(quality)
        members = np.zeros(R, bool)
        gain = 0.0
        if match.any():
            q = quality[match]
            listed = match & (quality >= q.max() - learning.alpha_grasp * (q.max() - q.min()) - 1e-5)
            assert chosen[t] in actions[listed]
            members = match & (actions == chosen[t])
            gain = np.log10(abs(rewards[t]) + 1) * np.sign(rewards[t])
        else:
            assert chosen[t] == NO_ACTION
        usage += members
        past.append(members)
        for back, earlier in enumerate(reversed(past[-(learning.bp_max + 1) :])):
            total = total + learning.trace_decay**back * gain * earlier
        last = (members, rewards[t]) if match.any() else None
    if last is not None:
        quality, error = learn(np.zeros(R, bool), STEPS - 1)
    return quality, error, np.where(usage > 0, total / np.maximum(usage, 1), 0), usage, np.array(history)


@pytest.mark.parametrize(
    ("learning", "period"),
    [
        (Learning(), PERIOD),
        (Learning(alpha_q=0.4, alpha_q_final=0.05, beta_q=0.3, bp_max=3, trace_decay=0.5), 12),
        (Learning(alpha_grasp=0.6, bp_max=0, alpha_q=0.3), 5),
        (Learning(bp_max=24, trace_decay=0.9), 30),
    ],
)
def test_an_agents_life_against_plain_python(learning, period):
    rng = np.random.default_rng(period)
    masks = np.array([[1 << int(rng.integers(0, 6)) | (1 << 40 if rng.random() < 0.3 else 0) for _ in range(N)]
                      for _ in range(R)])  # fmt: skip
    words = np.stack([masks & 0xFFFFFFFF, masks >> 32]).astype(np.uint32)  # [2, R, n]
    actions = rng.integers(0, 5, (R, N)).astype(np.uint8) * 13
    clause = rng.random((STEPS, 64, N)) < 0.25
    clause[:, :, 0] &= rng.random((STEPS, 1)) < 0.7  # agent 0 often has nothing to do
    bits = (clause.astype(np.uint64) << np.arange(64, dtype=np.uint64)[:, None]).sum(axis=1, dtype=np.uint64)
    truths = np.stack([bits & np.uint64(0xFFFFFFFF), bits >> np.uint64(32), bits * 0, bits * 0], 1).astype(np.uint32)
    rewards = (rng.normal(0, 2, (STEPS, N)) + 1).astype(np.float32)
    rules = Rules(jnp.asarray(words), jnp.asarray(actions))
    parameters = LearningParameters.of(learning)
    chosen, qualities, memory = jax.device_get(
        live(rules, jnp.asarray(truths), jnp.asarray(rewards), jnp.array([5, 6], jnp.uint32), parameters, period)
    )
    assert (chosen == NO_ACTION).any()
    for i in range(N):
        q, e, s, u, history = plain(
            [(int(a), int(b)) for a, b in words[:, :, i].T], actions[:, i],
            [(int(w[0]), int(w[1])) for w in truths[:, :, i]], rewards[:, i].astype(float), chosen[:, i], learning,
        )  # fmt: skip
        np.testing.assert_allclose(qualities[:, :, i], history, atol=1e-4)
        np.testing.assert_allclose(memory.quality[:, i], q, atol=1e-4)
        np.testing.assert_allclose(memory.error[:, i], e, atol=1e-4)
        np.testing.assert_allclose(memory.strength[:, i], s, atol=1e-4)
        np.testing.assert_array_equal(memory.usage[:, i], u)
    assert memory.usage.max() > 3


def test_nothing_is_known_at_first():
    rules = Rules(jnp.zeros((3, R, N), jnp.uint32), jnp.zeros((R, N), jnp.uint8))
    memory = start(rules, LearningParameters.of(Learning()))
    for name in ("quality", "error", "strength", "usage"):
        table = getattr(memory, name)
        assert table.shape == (R, N)
        assert not table.any()


def test_the_first_step_learns_nothing():
    """No action set came before it, whatever the memory's reward says."""
    rules = Rules(jnp.ones((1, R, N), jnp.uint32), jnp.zeros((R, N), jnp.uint8))
    parameters = LearningParameters.of(Learning())
    memory = start(rules, parameters)
    truth, key = jnp.ones((4, N), jnp.uint32), jnp.zeros(2, jnp.uint32)
    step = jax.jit(decide)
    after, action = step(memory, rules, truth, key, jnp.int32(0), jnp.float32(0), parameters)
    assert not after.quality.any()
    assert not after.error.any()
    assert action.tolist() == [0] * N


def test_choices_follow_from_key_and_step_alone():
    rules = Rules(jnp.ones((1, R, N), jnp.uint32), jnp.asarray(np.arange(R)[:, None].repeat(N, 1).astype(np.uint8)))
    parameters = LearningParameters.of(Learning())
    memory, truth = start(rules, parameters), jnp.ones((4, N), jnp.uint32)
    step = jax.jit(decide)

    def choices(key, times):
        key = jnp.array(key, jnp.uint32)
        return [step(memory, rules, truth, key, jnp.int32(t), jnp.float32(0), parameters)[1].tolist() for t in times]

    times = range(40)
    assert choices((1, 2), times) == choices((1, 2), times)
    assert choices((1, 2), times) != choices((1, 3), times)
    drawn = np.array(choices((1, 2), times))
    assert len(np.unique(drawn)) == R  # all qualities are 0: everything is drawn
    assert (drawn[:, 0] != drawn[:, 1]).mean() > 0.7  # agents draw for themselves
