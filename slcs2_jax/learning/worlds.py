"""Where a training takes place: worlds of one kind, and which of them each of its episodes is in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slcs2_jax.config.arguments import of_kind
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse
from slcs2_jax.config.settings import Settings
from slcs2_jax.search.keys import PURPOSE_TRAINING, seed_sequence
from slcs2_jax.world.scenario import Scenario, make_scenario

Worlds = Sequence[tuple[Settings, Sequence[int]]]
_FREE = ("world", "jammers", "search", "checkpoint", "compute", "knowledge", "seed", "instances", "run_dir", "plugins")


@dataclass(frozen=True, eq=False)
class TrainingWorlds:
    """Scenarios that share agents, physics, task and grammar.

    settings: of the first, which hold for all but for the world. scenarios: at least one. record: what they are, JSON.
    """

    settings: Settings
    scenarios: tuple[Scenario, ...]
    record: object

    @classmethod
    def of(cls, worlds: Worlds) -> TrainingWorlds:
        """The worlds of all these settings' seeds.

        Raises InputError for none, for an impossible one, or for settings that differ in more than the world.
        """
        if not isinstance(worlds, Sequence) or not worlds:
            raise refuse("worlds", type(worlds).__name__, "a list of pairs of Settings and seeds, at least one")
        scenarios, record = [], []
        first = of_kind("worlds", worlds[0][0], Settings)
        for settings, seeds in worlds:
            if _physics(of_kind("worlds", settings, Settings)) != _physics(first):
                raise InputError("worlds: settings of different swarms; accepted are those that differ in the world")
            if settings.world.wall_thickness != first.world.wall_thickness:
                raise InputError("worlds: walls of different thickness; accepted are those of one")
            if not seeds:
                raise refuse("worlds", "no seeds", "at least one for each of the settings")
            scenarios += [make_scenario(settings, seed) for seed in seeds]
            record.append([repr(settings.world), repr(settings.jammers), [int(seed) for seed in seeds]])
        return cls(first, tuple(scenarios), [repr(_physics(first)), record])

    def drawn(self, seed: int, episode: int) -> Scenario:
        """The scenario of an episode: every one comes once, in an order of its own, before any comes again."""
        turn, place = divmod(episode, len(self.scenarios))
        rng = np.random.Generator(np.random.PCG64(seed_sequence(seed, PURPOSE_TRAINING, turn, 0, 0)))
        return self.scenarios[rng.permutation(len(self.scenarios))[place]]


def _physics(settings: Settings) -> Settings:
    """The settings with all that may differ from world to world, or does not matter, as it is by default."""
    usual = Settings()
    return replace(settings, **{name: getattr(usual, name) for name in _FREE})
