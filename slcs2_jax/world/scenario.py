"""Scenarios: one environment instance each, made by name from settings and a seed, or from a file (model section 2)."""

from __future__ import annotations

from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.registry import KINDS
from slcs2_jax.config.settings import Settings
from slcs2_jax.world.layout import Jammer, Scenario
from slcs2_jax.world.scenario_check import check_scenario
from slcs2_jax.world.world_file import scenario_from_text

__all__ = ["Jammer", "Scenario", "check_scenario", "make_scenario"]


def make_scenario(settings: Settings, seed: int) -> Scenario:
    """The scenario of a seed: from `world.file`, or by the maker that `world.scenario` names.

    The same settings of world, jammers, radio range and swarm size give the same scenario for every algorithm, in any
    batch.

    Raises:
        InputError: no such scenario can be made, or the seed is none; or what a user's maker returns is no scenario.
    """
    of_kind("settings", settings, Settings)
    seed = whole("seed", seed, 0, 2**64 - 1)
    if settings.world.content is not None:
        return scenario_from_text(settings, seed)
    name = settings.world.scenario
    made = KINDS["scenario"].get(name)(settings, seed)
    home = KINDS["scenario"].home(name)
    if home is not None:
        try:
            check_scenario(of_kind("scenario", made, Scenario), settings)
        except InputError as error:
            raise InputError(f"world.scenario={name} of {home}: {error}") from None
    return made
