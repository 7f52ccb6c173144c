"""What every training does: go on until its budget is spent, save now and then, keep policies, and tell."""

from __future__ import annotations

import abc
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slcs2_jax.config.arguments import whole
from slcs2_jax.config.errors import InputError
from slcs2_jax.learning.network_settings import NetworkSettings
from slcs2_jax.learning.training_folder import POLICY, TrainingFolder
from slcs2_jax.learning.worlds import TrainingWorlds, Worlds
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.results import Report
from slcs2_jax.running.stopping import Stopped, StopRequest


class Training(abc.ABC):
    """A training under way. Nothing depends on the budget, so that a greater one goes on where a smaller one ended.

    Attributes:
        worlds: where it takes place.
        seed: all that is drawn follows from it.
        start: the network that it began with.
        env_steps: done so far.
    """

    algorithm: str
    advice: str  # accepted in place of settings with which numbers grow out of bounds

    def __init__(
        self, settings: Any, network: NetworkSettings, worlds: Worlds, seed: int, folder: str | Path | None
    ) -> None:
        """A beginning.

        Args:
            settings: of the algorithm; `snapshot` among them.
            network: of these settings.
            worlds, seed, folder: as the algorithm's `train` takes them.

        Raises:
            InputError: worlds or a seed that are none.
        """
        self.worlds, self.seed = TrainingWorlds.of(worlds), whole("seed", seed, 0, 2**64 - 1)
        self.start = network.start(self.worlds.settings, self.seed)
        self.env_steps = 0
        self._snapshot: int = settings.snapshot
        identity = {
            "algorithm": self.algorithm,
            "settings": repr(settings),
            "worlds": self.worlds.record,
            "seed": self.seed,
        }
        self.folder = TrainingFolder(folder, identity)

    @abc.abstractmethod
    def advance(self) -> dict[str, Any]:
        """Do the next part, count its env-steps, and return what to note of it; floats must be finite."""

    @abc.abstractmethod
    def saved(self) -> tuple[Any, dict[str, Any]]:
        """What it needs to go on: a pytree of arrays, and counters, JSON-able."""

    @abc.abstractmethod
    def restore(self, tree: Any, counters: Mapping[str, Any]) -> None:
        """Become what `saved` returned once."""

    @abc.abstractmethod
    def policy(self) -> BoundPolicy:
        """As it is now."""

    @property
    @abc.abstractmethod
    def episodes(self) -> int:
        """How many have been begun."""

    @property
    @abc.abstractmethod
    def fitness(self) -> float:
        """What to tell of it; NaN if nothing is known."""

    def run(self, budget_env_steps: int, report: Report | None) -> BoundPolicy:
        """Go on from what the folder holds until the budget is spent.

        Raises Stopped by a signal, once all is saved; InputError for a folder that holds something else, or for numbers
        that are not finite any more, which are not saved.
        """
        budget = whole("budget_env_steps", budget_env_steps, 1, 10**15)
        seconds = self.worlds.settings.checkpoint.seconds
        saved = time.monotonic()
        with self.folder, StopRequest() as stop:
            found = self.folder.load(*self.saved())
            if found is not None:
                self.restore(*found)
            while self.env_steps < budget:
                self._advance()
                if report is not None:
                    report.generation(
                        done=[min(self.env_steps, budget)],
                        best=[self.fitness],
                        evaluations=self.episodes,
                        env_steps=self.env_steps,
                    )
                if stop.number is not None:
                    self.folder.save(*self.saved())
                    raise Stopped(f"stopped after {self.env_steps} env-steps; all is saved", stop.number)
                if seconds is not None and time.monotonic() - saved >= seconds:
                    self.folder.save(*self.saved())
                    saved = time.monotonic()
            self.folder.save(*self.saved())
            return self._keep(POLICY)

    def _advance(self) -> None:
        before = self.env_steps
        noted = self.advance()
        _check_finite(self.algorithm, noted, self.env_steps, self.advice)
        self.folder.note({"env_steps": self.env_steps, **noted})
        reached = self.env_steps // self._snapshot
        if reached > before // self._snapshot:
            self._keep(f"policy_{reached * self._snapshot:012d}.npz")

    def _keep(self, name: str) -> BoundPolicy:
        policy = self.policy()
        about = {"algorithm": self.algorithm, "env_steps": self.env_steps, "episodes": self.episodes}
        self.folder.save_policy(policy, about, name)
        return policy


def _check_finite(algorithm: str, noted: Mapping[str, Any], env_steps: int, advice: str) -> None:
    odd = [name for name, value in noted.items() if isinstance(value, float) and not math.isfinite(value)]
    if odd:
        raise InputError(
            f"{algorithm}: not finite any more after {env_steps} env-steps: {', '.join(odd)}; accepted is {advice}"
        )
