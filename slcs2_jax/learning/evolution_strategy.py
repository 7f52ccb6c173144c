"""An evolution strategy on a network's weights, through the evaluator (Salimans et al. 2017, arXiv 1703.03864).

What counts is the fitness of whole episodes, as for evolved rules; rewards are not looked at.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np
import optax
from jax.flatten_util import ravel_pytree
from numpy.typing import NDArray

from slcs2_jax.config.arguments import of_kind
from slcs2_jax.learning.optimiser import stepped
from slcs2_jax.learning.strategy_settings import Strategy
from slcs2_jax.learning.training import Training
from slcs2_jax.learning.worlds import Worlds
from slcs2_jax.policy.bound import BoundPolicy, bind
from slcs2_jax.policy.trained_network import NAME
from slcs2_jax.results import Report
from slcs2_jax.running.evaluator import Evaluator
from slcs2_jax.search.keys import PURPOSE_TRAINING, seed_sequence

__all__ = ["Strategy", "train"]


def train(
    settings: Strategy,
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
        budget_env_steps: it ends with the generation that brings so many. A budget that was raised goes on.
        folder: where the curve (`curve.jsonl`, a line a generation), the checkpoint and the policies are saved, as
            often as `checkpoint.seconds` of the first settings says. What is there already is gone on with, to the same
            bytes as without the interruption. Ctrl-C saves first.
        report: who is told of progress.

    Returns:
        The network in the middle of the last generation.

    Raises:
        InputError: an argument that is none; a folder that holds something else; or numbers that grew out of bounds.
        StorageError: the disk refuses.
    """
    return _Training(of_kind("settings", settings, Strategy), worlds, seed, folder).run(budget_env_steps, report)


def ranked(fitness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ranks in place of fitness, from -0.5 for the least to 0.5, equal ones sharing theirs: float64 of the same shape
    (Salimans et al., section 2.1)."""
    _, place, count = np.unique(fitness, return_inverse=True, return_counts=True)
    middle = np.cumsum(count) - (count + 1) / 2
    ranks: NDArray[np.float64] = middle[place.reshape(fitness.shape)] / max(fitness.size - 1, 1) - 0.5
    return ranks


def gradient(noise: NDArray[np.float32], fitness: NDArray[np.float64], deviation: float) -> NDArray[np.float32]:
    """Where the fitness grows, estimated from pairs of opposite networks (Salimans et al., algorithm 1; antithetic:
    Brockhoff et al. 2010).

    Args:
        noise: [m, D], of the first network of each pair.
        fitness: [2, m], of those with the noise and of those against it.
        deviation: sigma.

    Returns:
        [D].
    """
    for_it, against = ranked(fitness)
    estimate = (for_it - against) @ noise.astype(np.float64) / (2 * len(noise) * deviation)
    return estimate.astype(np.float32)


class _Training(Training):
    """Of one middle network. weights: float32 [D], all of its in a row."""

    algorithm = "strategy"
    advice = "a smaller strategy.learning_rate"

    def __init__(self, settings: Strategy, worlds: Worlds, seed: int, folder: str | Path | None) -> None:
        super().__init__(settings, settings.network, worlds, seed, folder)
        self._settings, self._evaluator = settings, Evaluator(self.worlds.settings)
        weights, self._network = ravel_pytree(self.start.given["network"])
        self._optimiser = optax.adam(settings.learning_rate)
        self.weights, self.optimiser = np.asarray(weights), self._optimiser.init(weights)
        self.generation, self._best = 0, math.nan

    def saved(self) -> tuple[Any, dict[str, Any]]:
        return (self.weights, self.optimiser), {"generation": self.generation, "env_steps": self.env_steps}

    def restore(self, tree: Any, counters: Mapping[str, Any]) -> None:
        self.weights, self.optimiser = tree
        self.generation, self.env_steps = counters["generation"], counters["env_steps"]

    def policy(self) -> BoundPolicy:
        return self._of(self.weights)

    @property
    def episodes(self) -> int:
        return self.generation * self._settings.population * self._settings.worlds

    @property
    def fitness(self) -> float:
        return self._best

    def _of(self, weights: NDArray[np.float32]) -> BoundPolicy:
        """The network with these weights, [D]."""
        network = jax.device_get(self._network(jax.numpy.asarray(weights)))
        return bind(NAME, self.start.given | {"network": network})

    def advance(self) -> dict[str, Any]:
        settings = self._settings
        rng = np.random.Generator(np.random.PCG64(seed_sequence(self.seed, PURPOSE_TRAINING, self.generation)))
        noise = rng.normal(size=(settings.population // 2, self.weights.size)).astype(np.float32)
        shift = np.float32(settings.deviation) * noise
        networks = [self._of(self.weights + one) for one in (*shift, *-shift)]
        places = range(self.generation * settings.worlds, (self.generation + 1) * settings.worlds)
        found = self._evaluator(networks, [self.worlds.drawn(self.seed, place) for place in places])
        self._climb(gradient(noise, found.mean.reshape(2, -1), settings.deviation))
        self.env_steps += int(found.steps.sum())
        self.generation, self._best = self.generation + 1, float(found.mean.max())
        return {
            "generation": self.generation,
            "fitness": float(found.mean.mean()),
            "best": self._best,
            "delivered": float(found.delivered.mean()),
            "norm": float(np.linalg.norm(self.weights)),
        }

    def _climb(self, uphill: NDArray[np.float32]) -> None:
        """A step of Adam, and weight decay beside it (Loshchilov and Hutter 2019, arXiv 1711.05101)."""
        settings = self._settings
        change, self.optimiser = stepped(self._optimiser, -uphill, self.optimiser)
        kept = np.float32(1 - settings.learning_rate * settings.decay)
        self.weights = np.asarray(change) + kept * self.weights
