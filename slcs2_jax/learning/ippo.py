"""IPPO: independent proximal policy optimisation, all agents by one network (de Witt et al. 2020, arXiv 2011.09533).

Reward is the environment's, what `task.reward` names; by default the progress of packets and agents. Episodes are
whole; one that ends within a chunk stands still until the next.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from slcs2_jax import runtime
from slcs2_jax.config.arguments import of_kind
from slcs2_jax.config.errors import refuse
from slcs2_jax.learning.collection import Collector
from slcs2_jax.learning.ippo_settings import Ippo
from slcs2_jax.learning.learner import Update
from slcs2_jax.learning.training import Training
from slcs2_jax.learning.worlds import Worlds
from slcs2_jax.policy import layers
from slcs2_jax.policy.bound import BoundPolicy, bind
from slcs2_jax.policy.trained_network import NAME, TrainedNetwork
from slcs2_jax.results import Report
from slcs2_jax.search.keys import PURPOSE_NETWORK, seed_sequence, training_key
from slcs2_jax.swarm.step import Physics
from slcs2_jax.swarm.task import Score
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.emitters import jammer_room

__all__ = ["Ippo", "train"]

_begin = jax.jit(Collector.begin)
_refill = jax.jit(Collector.refill, donate_argnums=1)
_run = jax.jit(Update.__call__, donate_argnums=(1, 2))


def train(
    settings: Ippo,
    worlds: Worlds,
    *,
    seed: int,
    budget_env_steps: int,
    folder: str | Path | None = None,
    report: Report | None = None,
) -> BoundPolicy:
    """Train a network.

    Args:
        settings: how.
        worlds: pairs of settings and seeds of worlds; see `TrainingWorlds`.
        seed: of the training; everything drawn follows from it.
        budget_env_steps: it ends with the update that brings so many. A budget that was raised goes on.
        folder: where the curve (`curve.jsonl`, a line an update), the checkpoint and the policies are saved, as often
            as `checkpoint.seconds` of the first settings says. What is there already is gone on with, to the same bytes
            as without the interruption, on CPUs. Ctrl-C saves first.
        report: who is told of progress.

    Returns:
        The policy as it is at the end: agents draw their actions, as in training.

    Raises:
        InputError: an argument that is none; a folder that holds something else; or numbers that grew out of bounds.
        StorageError: the disk refuses.
    """
    return _Training(of_kind("settings", settings, Ippo), worlds, seed, folder).run(budget_env_steps, report)


class _Training(Training):
    """Of one network. playing: the number of the episode in each slot."""

    algorithm = "ippo"
    advice = "a smaller ippo.learning_rate"

    def __init__(self, settings: Ippo, worlds: Worlds, seed: int, folder: str | Path | None) -> None:
        super().__init__(settings, settings.network, worlds, seed, folder)
        of_all = self.worlds.settings
        period = of_all.swarm.sharing_period
        if settings.chunk % period:
            raise refuse("ippo.chunk", settings.chunk, f"a multiple of swarm.sharing_period={period}")
        runtime.configure(of_all.compute)
        self._settings = settings
        policy = of_kind("policy", self.start.policy, TrainedNetwork)
        self._physics = Physics.of(of_all, self.start.language)
        self._collector = Collector(self._physics, policy, period)
        self._rule = Update(settings, self._collector)
        self._room = (wall_capacity(self.worlds.scenarios), jammer_room(self.worlds.scenarios))
        self.updates, self.playing = 0, list(range(settings.episodes))
        rng = np.random.Generator(np.random.PCG64(seed_sequence(self.seed, PURPOSE_NETWORK, 1)))
        network = self.start.given["network"]
        value = layers.layer(rng, network["out"]["w"].shape[0], 1, 1.0)
        self._learner, self._episodes = self._rule.begin(network, value), _begin(self._collector, *self._given())

    def saved(self) -> tuple[Any, dict[str, Any]]:
        counters = {"updates": self.updates, "env_steps": self.env_steps, "playing": self.playing}
        return (self._learner, self._episodes), counters

    def restore(self, tree: Any, counters: Mapping[str, Any]) -> None:
        self._learner, self._episodes = jax.tree.map(jnp.asarray, tree)
        self.updates, self.env_steps, self.playing = (counters[name] for name in ("updates", "env_steps", "playing"))

    def policy(self) -> BoundPolicy:
        return bind(NAME, self.start.given | {"network": jax.device_get(self._learner.weights["network"])})

    @property
    def episodes(self) -> int:
        return max(self.playing) + 1

    @property
    def fitness(self) -> float:
        ended = [line["fitness"] for line in self.folder.last(50) if line["episodes"]]
        return float(np.mean(ended)) if ended else math.nan

    def _given(self) -> tuple[Any, Any]:
        """Worlds and keys of the slots' episodes, the first of each slot cut short as `stagger` says."""
        slots, scenarios = len(self.playing), []
        for slot, number in enumerate(self.playing):
            scenario = self.worlds.drawn(self.seed, number)
            if number == slot:
                cut = -(-self._settings.stagger * (slot + 1) // slots)
                scenario = dataclasses.replace(scenario, time_limit=min(cut, scenario.time_limit))
            scenarios.append(scenario)
        channels = self.start.channels
        walls, jammers = self._room
        arena = stack(scenarios, [channels] * slots, capacity=walls, width=1 + max(channels), jammers=jammers)
        keys = np.array([training_key(self.seed, number) for number in self.playing], np.uint32).T
        return arena, keys

    def advance(self) -> dict[str, Any]:
        """Collect, learn, and begin new episodes where some are over."""
        key = jax.random.key(int(seed_sequence(self.seed, PURPOSE_NETWORK, 2, self.updates).generate_state(1)[0]))
        self._learner, self._episodes, measures = _run(self._rule, self._learner, self._episodes, key, self._rate())
        state, arena = self._episodes.state, self._episodes.arena
        going = self._physics.task.running(state, arena, self._physics.swarm)
        told, going = jax.device_get((measures, going))
        noted = {name: value.item() for name, value in told.items()}
        self.env_steps += noted.pop("steps")
        self.updates += 1
        ended = np.flatnonzero(~going)
        noted |= self._ended(ended)
        if ended.size:
            self._renew(ended)
        return {"update": self.updates, **noted}

    def _rate(self) -> np.float32:
        """The learning rate of the next update."""
        settings = self._settings
        left = 1.0 if settings.anneal is None else max(0.0, 1 - self.env_steps / settings.anneal)
        return np.float32(settings.learning_rate * left)

    def _ended(self, ended: NDArray[np.intp]) -> dict[str, Any]:
        """Mean fitness and packets delivered of the episodes that have ended, those cut short left out."""
        whole = [slot for slot in ended if self.playing[slot] >= len(self.playing)]
        if not whole:
            return {"episodes": 0}
        packets, task = self.worlds.settings.swarm.packets, self._physics.task
        state, arena = self._episodes.state, self._episodes.arena
        found = jax.device_get((state.delivered, state.t, arena.time_limit, task.measure(state, arena)))
        scores = []
        for slot in whole:
            delivered, steps, limit, measured = jax.tree.map(lambda leaf, slot=slot: leaf[..., slot], found)
            scores.append(Score(
                delivered=int(delivered), packets=packets, steps=int(steps), time_limit=int(limit), measures=measured
            ))  # fmt: skip
        return {
            "episodes": len(whole),
            "fitness": float(np.mean([task.fitness(score) for score in scores])),
            "delivered": float(np.mean([score.delivered for score in scores])),
        }

    def _renew(self, ended: NDArray[np.intp]) -> None:
        """New episodes in these slots."""
        following = max(self.playing) + 1
        for number, slot in enumerate(ended):
            self.playing[slot] = following + number
        entering = np.isin(np.arange(len(self.playing)), ended)
        self._episodes = _refill(self._collector, self._episodes, *self._given(), entering)
