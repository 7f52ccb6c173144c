"""JaxMARL's interface, whether `jaxmarl` is installed or not."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.adapters import spaces, vector
from slcs2_jax.adapters.jaxmarl import JaxMARL
from slcs2_jax.config import InputError
from slcs2_jax.env import Env, make

LIMIT = 25
AGENTS = ["agent_0", "agent_1", "agent_2"]


@functools.cache
def environment() -> Env:
    return make("open_short", {"swarm.agents": 3, "swarm.packets": 2, "world.time_limit": LIMIT})


@functools.cache
def adapter() -> JaxMARL:
    return JaxMARL(environment())


def nothing() -> dict[str, jax.Array]:
    return dict.fromkeys(AGENTS, jnp.int32(environment().spaces.actions - 1))


def assert_equal_trees(one, other):
    jax.tree.map(np.testing.assert_array_equal, one, other)


def test_names_and_spaces_are_those_of_the_agents():
    env, inner = adapter(), environment()
    assert (env.agents, env.num_agents, env.name) == (AGENTS, 3, "slcs2_open_short")
    assert env.agent_classes == {"agent": AGENTS}
    entries = len(vector.names(inner, clauses=False))
    for agent in AGENTS:
        assert env.observation_space(agent).shape == (entries,)
        assert env.action_space(agent).n == inner.spaces.actions
        assert env.action_space(agent).contains(env.action_space(agent).sample(jax.random.key(0)))
    more = JaxMARL(inner, clauses=True).observation_space("agent_0")
    assert more.shape == (entries + inner.spaces.clauses,)


def test_steps_are_those_of_the_environment_by_agent():
    env, inner = adapter(), environment()
    key = jax.random.key(4)
    observations, state = env.reset(key)
    seen, plain = jax.jit(inner.reset)(key, inner.params)
    assert list(observations) == AGENTS
    assert_equal_trees(state, plain)
    available = env.get_avail_actions(state)
    actions = {agent: jnp.argmax(available[agent]).astype(jnp.int32) for agent in AGENTS}
    for number, agent in enumerate(AGENTS):
        np.testing.assert_array_equal(observations[agent], seen.features[number])
        np.testing.assert_array_equal(available[agent], seen.action_mask[number])
    assert_equal_trees(env.get_obs(state), observations)
    together = jnp.stack([actions[agent] for agent in AGENTS])
    observations, state, rewards, done, info = env.step(key, state, actions)
    seen, plain, reward, _, _, told = jax.jit(inner.step)(key, plain, together, inner.params)
    assert_equal_trees(state, plain)
    for number, agent in enumerate(AGENTS):
        np.testing.assert_array_equal(observations[agent], seen.features[number])
        assert rewards[agent] == reward[number]
    assert any(rewards.values())
    assert {name: bool(flag) for name, flag in done.items()} == dict.fromkeys([*AGENTS, "__all__"], False)
    assert {leaf.shape for leaf in info.values()} == {(3,)}
    np.testing.assert_array_equal(info["contribution"], told["contribution"])
    assert set(info) == {*told, "terminated", "truncated"}


def test_an_episode_that_is_over_is_followed_by_the_next():
    env = adapter()
    _, state = env.reset(jax.random.key(0))
    for t in range(LIMIT):
        key = jax.random.key(100 + t)
        before = state
        observations, state, _, done, info = env.step(key, state, nothing())
        assert all(done.values()) == any(done.values()) == (t == LIMIT - 1)
    assert info["truncated"].all()
    assert not info["terminated"].any()
    assert (info["steps"] == LIMIT).all()
    assert_equal_trees((observations, state), env.reset(jax.random.split(key)[1]))
    _, elsewhere = env.reset(jax.random.key(77))
    observations, state, *_ = env.step(key, before, nothing(), elsewhere)
    assert_equal_trees((observations, state), (env.get_obs(elsewhere), elsewhere))


def test_many_episodes_go_on_under_vmap_and_scan():
    env = adapter()

    @jax.jit
    def rollout(key):
        keys = jax.random.split(key, 4)
        _, state = jax.vmap(env.reset)(keys)

        def one(state, key):
            available = jax.vmap(env.get_avail_actions)(state)
            draws = jax.random.split(key, (4, 3))
            actions = {
                agent: jax.vmap(lambda k, mask: jax.random.categorical(k, jnp.where(mask, 0.0, -jnp.inf)))(
                    draws[:, number], available[agent]
                )
                for number, agent in enumerate(AGENTS)
            }
            _, state, rewards, done, _ = jax.vmap(env.step)(jax.random.split(key, 4), state, actions)
            return state, (rewards, done["__all__"])

        return jax.lax.scan(one, state, jax.random.split(key, 2 * LIMIT))[1]

    rewards, done = rollout(jax.random.key(1))
    assert rewards["agent_2"].shape == done.shape == (2 * LIMIT, 4)
    assert np.isfinite(rewards["agent_2"]).all()
    assert (np.asarray(done).sum(axis=0) >= 2).all()


def test_spaces_of_our_own_tell_what_lies_in_them():
    box, discrete = spaces.Box(-1.0, 2.0, (3,)), spaces.Discrete(5)
    assert box.contains(box.sample(jax.random.key(0)))
    assert not box.contains(jnp.array([0.0, 2.1, 0.0]))
    assert set(np.asarray(jax.vmap(discrete.sample)(jax.random.split(jax.random.key(0), 100))).tolist()) == set(
        range(5)
    )
    assert [bool(discrete.contains(x)) for x in (-1, 0, 4, 5)] == [False, True, True, False]


def test_what_is_no_environment_is_refused():
    with pytest.raises(InputError, match="env=str: accepted is a Env"):
        JaxMARL("open_short")
