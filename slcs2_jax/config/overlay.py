"""Settings for deploying something: those a solution evolved with, or the defaults, and what the command line sets."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.schema import settings_fields, settings_from
from slcs2_jax.config.settings import Compute, Settings
from slcs2_jax.config.store import CHOICES, Primary
from slcs2_jax.config.worlds import home_of

_OF_THE_SOLUTION = ("swarm.agents", "grammar", "rules.rules")
_LEFT_OUT = ("search", "knowledge", "checkpoint")  # nothing is searched for, and nothing saved on the way


def deployment_primary(
    name: str, solution: Settings | None, *, own: Mapping[str, Any], seed: int = 0, instances: int = 1
) -> Primary:
    """What a command that deploys composes its settings from.

    Args:
        name: the command's.
        solution: what the deployed solution evolved with; None if nothing that evolved is deployed.
        own: the command's own entries, with their defaults.
        seed, instances: defaults of this command.
    """
    if solution is not None and solution.worlds:
        solution, seed = home_of(solution, seed, 0)
    settings = dataclasses.replace(
        solution or Settings(), seed=seed, instances=instances, run_dir=None, plugins=(), compute=Compute()
    )
    choices = {group: None if solution else option for group, option in CHOICES.items() if group not in _LEFT_OUT}
    return Primary(name=name, settings=settings, choices=choices, own=own, left_out=_LEFT_OUT)


def deployment_settings(config: Mapping[str, Any], solution: Settings | None) -> Settings:
    """The settings in a configuration that was composed from `deployment_primary` (without the command's own entries).

    Raises InputError for a bad setting, and for one that the solution decides (agents, rules, grammar) given otherwise.
    """
    given = settings_from(config)
    if given.worlds:
        raise InputError("worlds: not here; accepted is worlds= of slcs2 evolve and slcs2 transfer")
    if solution is None:
        return given
    for section, field in settings_fields():
        value, fixed = (getattr(getattr(of, section) if section else of, field.attribute) for of in (given, solution))
        if field.name in _OF_THE_SOLUTION and value != fixed:
            raise refuse(field.name, value, f"{fixed}, as the solution has it")
    return dataclasses.replace(
        given, search=solution.search, knowledge=solution.knowledge, checkpoint=solution.checkpoint
    )


def take(config: Mapping[str, Any], *names: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """A configuration without some top-level entries, and those entries. Raises InputError if one is missing."""
    for name in names:
        if name not in config:
            raise InputError(f"{name}: has no default; accepted is {name}=VALUE")
    return {key: value for key, value in config.items() if key not in names}, {name: config[name] for name in names}
