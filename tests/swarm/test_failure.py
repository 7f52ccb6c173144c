"""Agents that fail: when, for how long, what they then do not do, and that no packet is forgotten."""

from __future__ import annotations

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import InputError, Settings, Swarm
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.failure import FailureParameters, who_is_down
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import stack
from slcs2_jax.world.scenario import make_scenario

AGENTS = 6


def settings(**said):
    return Settings(swarm=Swarm(agents=AGENTS, packets=40, **said))


def arena_of(said, batch=1):
    scenario = make_scenario(said, 2)
    return stack([scenario] * batch, [(0,)] * batch, capacity=(0, 0), width=1)


def keys(batch):
    return jnp.asarray(np.random.default_rng(0).integers(0, 2**32, (2, batch), dtype=np.uint32))


@partial(jax.jit, static_argnames="steps")
def play(arena, key, physics, steps, seed=0):
    """Random actions: the states before every step, what was seen in it, and what was done."""
    count = len(physics.language.vocabulary.actions)

    def one(state, words):
        state, seen = swarm.observe(state, arena, physics)
        action = jax.random.randint(words, state.x.shape, 0, count, jnp.int32)
        after, reward, outcome = swarm.act(action, seen, physics)
        return after, (state, seen, outcome, reward)

    state = swarm.begin(arena, key, physics)
    return jax.lax.scan(one, state, jax.random.split(jax.random.key(seed), steps))


def test_off_there_is_nothing_of_it():
    assert FailureParameters.of(Swarm()) is None
    assert FailureParameters.of(Swarm(recovery_steps=5.0, failure_keeps_packet=True)) is None
    said = settings()
    physics = Physics.of(said)
    state = jax.eval_shape(swarm.begin, arena_of(said), keys(1), physics)
    assert state.down is None
    assert state.lost is None
    assert physics.swarm.failures is None


def steps_down(rate, recovery, steps=400, batch=300, times=(), share=0.25):
    said = Swarm(agents=AGENTS, failure_rate=rate, recovery_steps=recovery, failures_at=times, failure_share=share)
    failures = FailureParameters.of(said)
    key = keys(batch)

    @jax.jit
    def walk(failures):
        def one(down, t):
            down = who_is_down(down, key, jnp.full(batch, t), failures)
            return down, down

        return jax.lax.scan(one, jnp.zeros((AGENTS, batch), bool), jnp.arange(steps))[1]

    return np.asarray(walk(failures))  # [steps, n, batch]


def test_the_hazard_and_the_time_to_recover_are_as_told():
    rate, recovery = 0.02, 8.0
    down = steps_down(rate, recovery)
    falls = (~down[:-1] & down[1:]).sum() / (~down[:-1]).sum()
    rises = (down[:-1] & ~down[1:]).sum() / down[:-1].sum()
    assert falls == pytest.approx(rate, rel=0.03)
    assert rises == pytest.approx(1 / recovery, rel=0.03)
    assert down[200:].mean() == pytest.approx(rate / (rate + 1 / recovery), rel=0.05)


def test_without_recovery_who_fails_stays_down():
    down = steps_down(0.01, None)
    assert (down[1:] >= down[:-1]).all()
    assert down[99].mean() == pytest.approx(1 - 0.99**100, abs=0.03)


@pytest.mark.parametrize(("share", "count"), [(0.25, 2), (0.5, 3), (1.0, 6), (0.05, 0)])
def test_at_given_times_a_share_fails_and_who_is_drawn(share, count):
    down = steps_down(0.0, None, steps=12, times=(0, 7), share=share)
    assert (down[0].sum(axis=0) == count).all()
    assert (down[6] == down[0]).all()
    assert (down[7].sum(axis=0) >= count).all()
    if 0 < count < AGENTS:
        assert down[0].mean(axis=1) == pytest.approx(count / AGENTS, abs=0.12)
        assert (down[7] != down[6]).any()


@pytest.mark.parametrize("keeps", [False, True])
def test_packets_are_conserved_and_the_episode_ends_when_none_is_under_way(keeps):
    said = settings(failure_rate=0.03, recovery_steps=20.0, failure_keeps_packet=keeps)
    end, (state, *_) = play(arena_of(said, 8), keys(8), Physics.of(said), 300)
    held = state.holding.sum(axis=1)
    np.testing.assert_array_equal(state.waiting + held + state.delivered + state.lost, 40)
    assert (np.diff(state.lost, axis=0) >= 0).all()
    assert (end.lost > 0).all() != keeps
    assert held.max() > 0
    if keeps:
        assert (end.lost == 0).all()
        assert (state.holding & state.down).any()
    else:
        assert not (state.holding & state.down).any()
        assert (np.asarray(state.history)[:, 0][np.asarray(state.down)] == 0).all()
    few = dataclasses.replace(end, waiting=jnp.zeros_like(end.waiting), delivered=40 - end.lost)
    assert not Physics.of(said).task.running(few, arena_of(said, 8), Physics.of(said).swarm).any()


def test_who_is_down_does_nothing_and_reaches_nobody():
    said = settings(failure_rate=0.05, recovery_steps=10.0, failure_keeps_packet=True)
    _, (state, seen, outcome, _) = play(arena_of(said, 4), keys(4), Physics.of(said), 200)
    down = np.asarray(state.down)
    assert 0.1 < down.mean() < 0.6
    assert not np.asarray(outcome.intent.acts)[down].any()
    assert np.asarray(outcome.intent.acts)[~down].any()
    assert (np.moveaxis(np.asarray(seen.truth), 1, -1)[down] == 0).all()
    drawn = seen.view.links
    heard = np.asarray(drawn.heard)  # [steps, node, self, batch]
    assert not np.moveaxis(heard, 1, -1)[down].any()
    assert not np.moveaxis(heard[:, :AGENTS], 2, -1)[down].any()
    assert heard.any()
    places = np.stack([state.node_x[:, :AGENTS], state.node_y[:, :AGENTS]])
    moved = (places[:, 1:] != places[:, :-1]).any(axis=0)
    assert not moved[down[:-1]].any()
    assert moved[~down[:-1]].any()
    accepted = np.asarray(outcome.air.accepted)  # [steps, C, sender, receiver, batch]
    assert not accepted[:, 0, :AGENTS].any(axis=2)[down].any()
    assert not accepted[:, 0, :, :AGENTS].any(axis=1)[down].any()
    assert accepted.any()


@pytest.mark.slow
def test_until_somebody_fails_the_world_is_the_same():
    plain, failing = settings(), settings(failures_at=(5,), failure_share=0.5)
    _, (one, *_) = play(arena_of(plain), keys(1), Physics.of(plain), 6)
    _, (other, *_) = play(arena_of(failing), keys(1), Physics.of(failing), 6)
    for name in ("node_x", "node_y", "power", "holding"):
        np.testing.assert_array_equal(getattr(one, name)[:5], getattr(other, name)[:5], err_msg=name)
    assert other.down[5].sum() == 3


def test_one_program_serves_every_rate():
    said = settings(failure_rate=0.1)
    made = Physics.of(said)
    count = []

    @jax.jit
    def lost(rate):
        count.append(rate)
        swarm_parameters = dataclasses.replace(made.swarm, failures=dataclasses.replace(made.swarm.failures, rate=rate))
        physics = dataclasses.replace(made, swarm=swarm_parameters)
        return swarm.begin(arena_of(said, 200), keys(200), physics).down.mean()

    found = [float(lost(jnp.float32(rate))) for rate in (0.0, 0.2, 1.0)]
    assert found == pytest.approx([0, 0.2, 1], abs=0.05)
    assert len(count) == 1


@pytest.mark.parametrize(
    "said", [{"failure_rate": 1.5}, {"failures_at": [3, 3]}, {"failures_at": 3}, {"failures_at": [-1]},
             {"recovery_steps": 0}, {"failure_share": 2}],
)  # fmt: skip
def test_impossible_failures_are_refused(said):
    with pytest.raises(InputError, match=r"swarm\..*accepted is"):
        Swarm(**said)
