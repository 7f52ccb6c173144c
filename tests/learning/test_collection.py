"""What is learnt from is what a deployment of the same network does."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax.config import Swarm, World
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.learning.collection import Collector
from slcs2_jax.policy import layers
from slcs2_jax.search.keys import fresh_deployment_key
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import stack
from slcs2_jax.world.scenario import make_scenario
from tests.learning.tiny import SETTINGS, ippo

SEEDS, STEPS = range(4_000_000, 4_000_004), 160
# Far apart, so that agents know more by what others share with them than by what they hear.
SPREAD = dataclasses.replace(
    SETTINGS,
    world=World(distance=600.0, start_radius=200.0, time_limit=150),
    swarm=Swarm(agents=6, packets=4),
)


@functools.cache
def collected(recurrent, settings=SETTINGS, likes=300):
    """Policy, episodes before and after, steps and the value behind them, of 160 steps in four worlds."""
    bound = ippo(recurrent=recurrent).network.start(settings, 3)
    bound.given["network"]["out"]["w"] *= likes  # and dislikes: at first all actions are about as likely
    collector = Collector(Physics.of(settings, bound.language), bound.policy, settings.swarm.sharing_period)
    arena = stack([make_scenario(settings, seed) for seed in SEEDS], [(0,)] * 4, capacity=(0, 0), width=1)
    keys = np.array([fresh_deployment_key(seed, 0) for seed in SEEDS], np.uint32).T
    value = layers.layer(np.random.default_rng(0), bound.given["network"]["out"]["w"].shape[0], 1, 1.0)
    begun = jax.jit(Collector.begin)(collector, arena, keys)
    network = jax.tree.map(jnp.asarray, bound.given["network"])
    ended, steps, after = jax.jit(Collector.collect, static_argnums=4)(collector, network, value, begun, STEPS)
    return bound, collector, (begun, ended), jax.device_get(steps), after


@pytest.mark.parametrize("recurrent", [0, 5])
def test_the_saved_policy_does_the_same_where_it_is_deployed(recurrent):
    bound, _, (_, ended), steps, _ = collected(recurrent, SPREAD)
    known = np.array([*bound.policy.actions, NO_ACTION])
    for place, seed in enumerate(SEEDS):
        recording = slcs2.replay(bound, SPREAD, seed=seed)
        length = len(recording.action)
        np.testing.assert_array_equal(recording.action, known[steps.action[:length, :, place]])
        assert recording.delivered[-1] == ended.state.delivered[place]
        assert steps.running[:, place].sum() == length
    found = slcs2.Evaluator(SPREAD)([bound], SEEDS)
    np.testing.assert_array_equal(found.delivered[0, :, 0], ended.state.delivered)
    np.testing.assert_array_equal(found.steps[0, :, 0], ended.state.t)


def test_no_action_is_taken_that_could_have_no_effect():
    _, _, _, steps, _ = collected(0)
    allowed = np.take_along_axis(steps.mask, steps.action[..., None], axis=-1)
    assert allowed.all()
    assert not steps.mask.all()
    assert len(np.unique(steps.action[steps.able])) > 3


def test_the_task_done_and_time_up_are_told_apart():
    settings = dataclasses.replace(SETTINGS, swarm=Swarm(agents=3, packets=1))
    _, _, (_, ended), steps, _ = collected(0, settings, likes=1)
    done = np.asarray(ended.state.delivered) == 1
    assert done.any()
    np.testing.assert_array_equal(steps.terminated.sum(axis=0), done)
    last = steps.running.sum(axis=0) - 1
    for place in range(4):
        assert not steps.over[: last[place], place].any()
        assert steps.over[last[place] :, place].all()
        assert steps.terminated[last[place], place] == done[place]
    _, _, _, long, _ = collected(0)
    cut = long.running.sum(axis=0) == 150
    assert cut.any()
    assert not long.terminated[:, cut].any()
    assert not long.reward[150:, :, cut].any()
    assert not long.able[150:, :, cut].any()


def test_nothing_is_remembered_when_an_episode_begins():
    _, collector, (begun, ended), steps, _ = collected(5)
    assert not np.asarray(begun.memory).any()
    assert not steps.memory[0].any()
    assert steps.memory[1:].any(axis=-1).all()
    entering = np.array([True, False, False, True])
    again = jax.jit(Collector.refill)(collector, ended, begun.arena, begun.state.key, entering)
    assert not np.asarray(again.memory)[:, entering].any()
    np.testing.assert_array_equal(np.asarray(again.memory)[:, ~entering], np.asarray(ended.memory)[:, ~entering])
    np.testing.assert_array_equal(again.state.t, np.where(entering, 0, ended.state.t))


def test_the_chances_noted_are_those_of_the_network():
    bound, _, _, steps, _ = collected(5)
    hidden = layers.unrolled(bound.given["network"], steps.memory[0], steps.figures)
    logits = np.where(steps.mask, layers.head(bound.given["network"]["out"], hidden), -np.inf)
    expected = np.take_along_axis(np.asarray(jax.nn.log_softmax(logits)), steps.action[..., None], axis=-1)[..., 0]
    running = np.broadcast_to(steps.running[:, None], expected.shape)
    np.testing.assert_allclose(steps.log_probability[running], expected[running], rtol=1e-3, atol=1e-4)
