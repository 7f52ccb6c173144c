"""The task: when an episode is over, what it scores, and what a step is worth (paper, fitness equation)."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax

from slcs2_jax.config.registry import KINDS
from slcs2_jax.config.settings import Settings
from slcs2_jax.swarm.outcome import Outcome
from slcs2_jax.swarm.reward import Progress, Reward
from slcs2_jax.swarm.state import State, SwarmParameters
from slcs2_jax.swarm.view import View, checked
from slcs2_jax.world.arena import Arena


@dataclasses.dataclass(frozen=True, kw_only=True)
class Score:
    """What an episode came to, as plain numbers, for its fitness.

    Attributes:
        delivered, packets: at the sink, and in all.
        steps, time_limit: taken, and allowed.
        measures: what the task's `measure` took from the last state, NumPy arrays without a batch axis.
    """

    delivered: int
    packets: int
    steps: int
    time_limit: int
    measures: dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Delivery:
    """The paper's task: carry all packets to the sink, soon. Derive from it, and register, for one of your own.

    A task is part of compiled programs: it must be hashable and never change.
    """

    reward: Reward = dataclasses.field(default_factory=Progress)

    def going_on(self, state: State, arena: Arena, parameters: SwarmParameters) -> jax.Array:
        """Whether packets are still under way: bool [...]. The time limit ends an episode in any case."""
        return state.settled < parameters.packets

    def running(self, state: State, arena: Arena, parameters: SwarmParameters) -> jax.Array:
        """Whether the episode goes on: bool [...]."""
        going = checked("task", type(self).__name__, self.going_on(state, arena, parameters), state.t, bool)
        return going & (state.t < arena.time_limit)

    def worth(self, view: View, after: State, outcome: Outcome) -> jax.Array:
        """The reward of the step for every agent: float32 [n, ...]."""
        value = self.reward(view, after, outcome)
        return checked("reward", type(self.reward).__name__, value, view.x, "float32")

    def measure(self, state: State, arena: Arena) -> dict[str, jax.Array]:
        """What to take from the last state for the fitness, and for reports: arrays [..., batch] by name."""
        return {}

    def fitness(self, score: Score) -> float:
        """Share delivered less share of time used; -1 without a delivery (paper, fitness equation)."""
        return score.delivered / score.packets - score.steps / score.time_limit


def task_of(settings: Settings) -> Delivery:
    """The task that the settings name, with the reward that they name. Raises InputError for a name that is none."""
    made: Delivery = KINDS["task"].get(settings.task.name)(KINDS["reward"].get(settings.task.reward)())
    return made
