"""The environment as PettingZoo's `ParallelEnv`, with gymnasium's spaces; `pip install slcs2_jax[rl]` brings both.

env = Parallel(slcs2_jax.make("open_short"))
observations, infos = env.reset(seed=0)
while env.agents:
    actions = {agent: env.action_space(agent).sample(seen["action_mask"]) for agent, seen in observations.items()}
    observations, rewards, terminations, truncations, infos = env.step(actions)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import jax
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from slcs2_jax.adapters import vector
from slcs2_jax.config import InputError
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.field import refuse
from slcs2_jax.env import Env, EnvState, Params, Seen

MOST_SEED = 2**32 - 1
ByAgent = dict[str, Any]


class Parallel(ParallelEnv):
    """One world, for learners on the host; a step is compiled once, and its arrays become NumPy's.

    An agent sees a dictionary: `observation`, a vector whose entries `vector.names` tells, and `action_mask`, int8 [A],
    which is in `info`, too. Its action is a whole number, see `Env.actions`. All agents end together.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "slcs2_jax", "render_modes": [], "is_parallelizable": True}
    render_mode = None

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
        self._reset, self._step = jax.jit(env.reset), jax.jit(env.step)
        self._seeds = np.random.default_rng()
        self._state: EnvState | None = None
        self._vectors: NDArray[np.float32] | None = None
        self.possible_agents = [f"agent_{number}" for number in range(env.agents)]
        self.agents: list[str] = []
        entries, actions = len(vector.names(env, clauses)), env.spaces.actions
        self.observation_spaces = {agent: _observation_space(entries, actions) for agent in self.possible_agents}
        self.action_spaces = {agent: spaces.Discrete(actions) for agent in self.possible_agents}

    def observation_space(self, agent: str) -> spaces.Dict:
        """Of one agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """Of one agent."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[ByAgent, ByAgent]:
        """Deploy the swarm in the world of `params`.

        Args:
            seed: all that is drawn follows from it, in this episode and, where later ones are given none, in them.
            options: not looked at; there for the convention.

        Raises:
            InputError: the seed is none.
        """
        if seed is not None:
            self._seeds = np.random.default_rng(whole("seed", seed, 0, MOST_SEED))
        seen, self._state = self._reset(self._seeds.integers(0, MOST_SEED, 2, np.uint32, endpoint=True), self.params)
        self.agents = list(self.possible_agents)
        return self._told(seen, {})

    def step(self, actions: Mapping[str, Any]) -> tuple[ByAgent, ByAgent, ByAgent, ByAgent, ByAgent]:
        """Everybody acts at once.

        Args:
            actions: a whole number for every agent.

        Returns:
            Observations, rewards, terminations (the task is done), truncations (time is up) and infos by agent.

        Raises:
            InputError: no episode is under way, or an agent has no action, or one that it cannot take.
        """
        if self._state is None or not self.agents:
            raise InputError("step: no episode is under way; accepted is a call after reset, until the agents are gone")
        action = np.array([self._action(agent, actions) for agent in self.agents], np.int32)
        seen, self._state, reward, terminated, truncated, told = self._step(None, self._state, action, self.params)
        observations, infos = self._told(seen, told)
        rewards = dict(zip(self.agents, np.asarray(reward).tolist(), strict=True))
        terminations = dict.fromkeys(self.agents, bool(terminated))
        truncations = dict.fromkeys(self.agents, bool(truncated))
        if terminated or truncated:
            self.agents = []
        return observations, rewards, terminations, truncations, infos

    def state(self) -> NDArray[np.float32]:
        """What all agents see, one after the other: float32 [n F]. Raises InputError before the first reset."""
        if self._vectors is None:
            raise InputError("state: no episode has begun; accepted is a call after reset")
        return self._vectors.reshape(-1)

    def render(self) -> None:
        """Nothing: `slcs2_jax.replay` shows episodes."""

    def _action(self, agent: str, actions: Mapping[str, Any]) -> int:
        if agent not in actions:
            raise refuse("step", f"no action of {agent}", "one for every agent")
        action = actions[agent]
        number = action.item() if isinstance(action, np.ndarray | jax.Array) and action.ndim == 0 else action
        return whole(f"action of {agent}", number, 0, self.env.spaces.actions - 1)

    def _told(self, seen: Seen, told: Mapping[str, Any]) -> tuple[ByAgent, ByAgent]:
        """Observations and infos by agent."""
        vectors, mask, told = jax.device_get((vector.vector(seen, self._clauses), seen.action_mask, dict(told)))
        self._vectors = vectors
        observations, infos = {}, {}
        for number, agent in enumerate(self.agents):
            allowed = mask[number].astype(np.int8)
            observations[agent] = {"observation": vectors[number], "action_mask": allowed}
            infos[agent] = {name: value[number] if value.ndim else value.item() for name, value in told.items()}
            infos[agent]["action_mask"] = allowed
        return observations, infos


def _observation_space(entries: int, actions: int) -> spaces.Dict:
    vectors, mask = spaces.Box(-np.inf, np.inf, (entries,), np.float32), spaces.MultiBinary(actions)
    return spaces.Dict({"observation": vectors, "action_mask": mask})
