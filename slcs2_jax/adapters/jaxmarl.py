"""The environment as JaxMARL's `MultiAgentEnv` (its version 0.2): dictionaries by agent, and a new episode by itself.

    env = JaxMARL(slcs2_jax.make("open_short"))
    observation, state = env.reset(key)
    observation, state, reward, done, info = env.step(key, state, {agent: 0 for agent in env.agents})

Where `jaxmarl` is installed, this is a subclass of its environment with its spaces; it works without, too.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp

from slcs2_jax.adapters import vector
from slcs2_jax.config.arguments import of_kind
from slcs2_jax.env import Env, EnvState, Params, Seen

try:
    from jaxmarl.environments.multi_agent_env import MultiAgentEnv
    from jaxmarl.environments.spaces import Box, Discrete
except ImportError:
    from slcs2_jax.adapters.spaces import Box, Discrete

    MultiAgentEnv = object

ByAgent = dict[str, Any]
jitted = functools.partial(jax.jit, static_argnums=0)


class JaxMARL(MultiAgentEnv):
    """One world, for JaxMARL's learners.

    An agent's observation is a vector, see `vector.names`; its action a whole number, see `Env.actions`. An agent is
    done when the episode is, be the task done or the time up; `info` tells these apart.
    """

    def __init__(self, env: Env, params: Params | None = None, *, clauses: bool = False) -> None:
        """An adapter.

        Args:
            env: what is stepped.
            params: world and physics, by default the environment's own.
            clauses: append the truth of the clauses to the features.

        Raises:
            InputError: `env` is no `Env`.
        """
        self.env = of_kind("env", env, Env)
        self.params = env.params if params is None else params
        self._clauses = clauses
        self.num_agents = env.agents
        self.agents = [f"agent_{number}" for number in range(env.agents)]
        entries = len(vector.names(env, clauses))
        self.observation_spaces = {agent: Box(-jnp.inf, jnp.inf, (entries,)) for agent in self.agents}
        self.action_spaces = {agent: Discrete(env.spaces.actions) for agent in self.agents}

    @property
    def name(self) -> str:
        """The kind of world and its range."""
        world = self.env.settings.world
        return f"slcs2_{world.environment}_{world.range}"

    @property
    def agent_classes(self) -> dict[str, list[str]]:
        """All agents are alike."""
        return {"agent": list(self.agents)}

    @property
    def _params(self) -> Params:
        """As if they were arguments: constants that the compiler may reckon with beforehand change the last bits."""
        params: Params = jax.lax.optimization_barrier(self.params)
        return params

    def observation_space(self, agent: str) -> Any:
        """Of one agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """Of one agent."""
        return self.action_spaces[agent]

    @jitted
    def reset(self, key: jax.Array) -> tuple[ByAgent, EnvState]:
        """Deploy the swarm: float32 [F] by agent, and the state."""
        seen, state = self.env.reset(key, self._params)
        return self._observations(seen), state

    @jitted
    def step(
        self, key: jax.Array, state: EnvState, actions: ByAgent, reset_state: EnvState | None = None
    ) -> tuple[ByAgent, EnvState, ByAgent, ByAgent, ByAgent]:
        """Everybody acts at once; where the episode is over, observations and state are those of the next.

        Args:
            key: the next episode, if one begins, is drawn from it, as JaxMARL does.
            state: from `reset` or `step`.
            actions: int scalars by agent.
            reset_state: where the next episode begins, if not at a new deployment.

        Returns:
            Observations, state, rewards, whether each agent and `__all__` are done, and `info`, every entry [n].
        """
        key, key_reset = jax.random.split(key)
        observations, after, rewards, done, info = self.step_env(key, state, actions)
        if reset_state is None:
            fresh, fresh_state = self.reset(key_reset)
        else:
            fresh, fresh_state = self.get_obs(reset_state), reset_state
        over = done["__all__"]
        chosen = functools.partial(jax.tree.map, lambda new, old: jnp.where(over, new, old))
        return chosen(fresh, observations), chosen(fresh_state, after), rewards, done, info

    def step_env(
        self, key: jax.Array, state: EnvState, actions: ByAgent
    ) -> tuple[ByAgent, EnvState, ByAgent, ByAgent, ByAgent]:
        """As `step`, without the next episode: one that is over stands still."""
        action = jnp.stack([jnp.asarray(actions[agent], jnp.int32) for agent in self.agents])
        seen, after, reward, terminated, truncated, told = self.env.step(key, state, action, self._params)
        done = dict.fromkeys([*self.agents, "__all__"], terminated | truncated)
        told = {**told, "terminated": terminated, "truncated": truncated}
        info = {name: jnp.broadcast_to(value, (self.num_agents,)) for name, value in told.items()}
        return self._observations(seen), after, dict(zip(self.agents, reward, strict=True)), done, info

    @jitted
    def get_obs(self, state: EnvState) -> ByAgent:
        """What the agents see of a state."""
        return self._observations(self.env.observe(state, self._params))

    @jitted
    def get_avail_actions(self, state: EnvState) -> ByAgent:
        """Actions that could have an effect now: bool [A] by agent; the last, to do nothing, is always there."""
        return dict(zip(self.agents, self.env.observe(state, self._params).action_mask, strict=True))

    def _observations(self, seen: Seen) -> ByAgent:
        return dict(zip(self.agents, vector.vector(seen, self._clauses), strict=True))
