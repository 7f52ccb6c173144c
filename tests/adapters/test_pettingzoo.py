"""PettingZoo's own tests of its parallel interface, and what they do not look at."""

from __future__ import annotations

import functools

import jax
import numpy as np
import pytest
from pettingzoo import ParallelEnv
from pettingzoo.test import parallel_api_test, parallel_seed_test

from slcs2_jax.adapters import vector
from slcs2_jax.adapters.pettingzoo import Parallel
from slcs2_jax.config import InputError
from slcs2_jax.env import Env, make

LIMIT = 40


@functools.cache
def environment() -> Env:
    return make("open_short", {"swarm.agents": 3, "swarm.packets": 2, "world.time_limit": LIMIT})


@functools.cache
def adapter(clauses: bool = False) -> Parallel:
    """Kept, because a step is compiled for each."""
    return Parallel(environment(), clauses=clauses)


def nothing(env: Parallel) -> dict[str, int]:
    return dict.fromkeys(env.agents, environment().spaces.actions - 1)


def test_it_passes_the_test_of_the_interface():
    assert isinstance(adapter(), ParallelEnv)
    parallel_api_test(adapter(), num_cycles=2 * LIMIT)


def test_it_passes_the_test_of_seeds():
    parallel_seed_test(lambda: Parallel(environment()), num_cycles=LIMIT)


def test_what_is_seen_lies_in_the_spaces_and_is_what_the_environment_shows():
    env, inner = adapter(clauses=True), environment()
    observations, infos = env.reset(seed=5)
    again, _ = env.reset(seed=5)
    assert env.agents == ["agent_0", "agent_1", "agent_2"]
    words = np.random.default_rng(5).integers(0, 2**32, 2, np.uint32)
    seen, _ = jax.jit(inner.reset)(words, inner.params)
    assert observations["agent_0"]["observation"].shape == (len(vector.names(inner, clauses=True)),)
    for number, agent in enumerate(env.agents):
        assert env.observation_space(agent).contains(observations[agent])
        expected = np.concatenate([seen.features[number], seen.clauses[number]])
        np.testing.assert_array_equal(observations[agent]["observation"], expected)
        np.testing.assert_array_equal(again[agent]["observation"], expected)
        np.testing.assert_array_equal(observations[agent]["action_mask"], seen.action_mask[number])
        np.testing.assert_array_equal(infos[agent]["action_mask"], seen.action_mask[number])
    assert env.state().shape == (3 * expected.size,)
    np.testing.assert_array_equal(env.state()[-expected.size :], expected)


def test_without_a_seed_episodes_differ_and_follow_from_the_last_seed():
    env = adapter()
    env.reset(seed=1)
    links = []
    for seed in (None, None, 1, None):
        env.reset(seed=seed)
        links.append(np.asarray(env._state.swarm.power))
    assert not np.array_equal(links[0], links[1])
    np.testing.assert_array_equal(links[0], links[3])


def test_all_agents_are_truncated_when_time_is_up_and_gone_then():
    env = adapter()
    env.reset(seed=0)
    for t in range(LIMIT):
        _, rewards, terminations, truncations, infos = env.step(nothing(env))
        late = t == LIMIT - 1
        assert terminations == dict.fromkeys(env.possible_agents, False)
        assert truncations == dict.fromkeys(env.possible_agents, late)
        assert rewards == dict.fromkeys(env.possible_agents, 0.0)
        assert env.agents == ([] if late else env.possible_agents)
        assert infos["agent_1"]["steps"] == t + 1
        assert infos["agent_1"]["contribution"] == 0
    with pytest.raises(InputError, match="no episode is under way"):
        env.step(nothing(env))


def test_agents_are_terminated_when_the_task_is_done():
    done = make("open_short", {"swarm.agents": 3, "swarm.packets": 2, "world.time_limit": LIMIT})
    env = Parallel(done, done.change(done.params, {"swarm.packets": 1}))
    env.reset(seed=0)
    env._state.seen.view.state.__dict__["delivered"] = np.int32(1)
    *_, terminations, truncations, _ = env.step(nothing(env))
    assert terminations == dict.fromkeys(env.possible_agents, True)
    assert truncations == dict.fromkeys(env.possible_agents, False)
    assert env.agents == []


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"agent_1": None}, "step=no action of agent_1: accepted is one for every agent"),
        ({"agent_1": 10**6}, "action of agent_1=1000000: accepted is a whole number from 0 to "),
        ({"agent_1": -1}, "action of agent_1=-1: accepted is "),
        ({"agent_1": 0.5}, "action of agent_1=0.5: accepted is "),
        ({"agent_1": "collect"}, "action of agent_1=collect: accepted is "),
    ],
)
def test_actions_that_are_none_are_refused_in_one_line(change, told):
    env = adapter()
    env.reset(seed=0)
    actions = {agent: action for agent, action in (nothing(env) | change).items() if action is not None}
    with pytest.raises(InputError) as caught:
        env.step(actions)
    assert str(caught.value).startswith(told)


def test_what_is_no_environment_and_what_is_no_seed_is_refused():
    with pytest.raises(InputError, match="env=str: accepted is a Env"):
        Parallel("open_short")
    with pytest.raises(InputError, match="seed=-1: accepted is "):
        adapter().reset(seed=-1)
    with pytest.raises(InputError, match="no episode has begun"):
        Parallel(environment()).state()
    with pytest.raises(InputError, match="no episode is under way"):
        Parallel(environment()).step({})
