"""Settings for evaluating a saved solution: those it evolved with, and on top of them what the command line sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse
from slcs2_jax.config.schema import accepted_paths, settings_fields, settings_from, unknown_setting
from slcs2_jax.config.settings import SECTIONS, Settings

# What each group of conf/ that shares its section with others sets; any other group sets its whole section.
_GROUPS = {
    "environment": ("environment", "buildings", "jammer"),
    "range": ("range", "distance", "time_limit"),
    "grammar": ("grammar",),
}
_OF_THE_EVALUATION = (("", "seed"), ("", "instances"), ("", "run_dir"))
_OF_THE_SOLUTION = ("swarm.agents", "grammar", "rules.rules")


def evaluation_settings(solution: Settings, composed: Mapping[str, Any], overrides: Sequence[str]) -> Settings:
    """The settings of an evaluation.

    Args:
        solution: what the solution evolved with.
        composed: the whole composed configuration, defaults included (without `solution` and `deployments`).
        overrides: what the command line set, as typed.

    Raises:
        InputError: for a bad setting, and for one that the solution decides (agents, rules, grammar) given otherwise.
    """
    given = settings_from(composed)
    chosen = set(_OF_THE_EVALUATION)
    for override in overrides:
        chosen |= _sets(override)
    values: dict[str, dict[str, Any]] = {section: {} for section in ("", *SECTIONS)}
    for section, field in settings_fields():
        source = given if (section, field.attribute) in chosen or section == "compute" else solution
        value = getattr(getattr(source, section) if section else source, field.attribute)
        fixed = getattr(getattr(solution, section) if section else solution, field.attribute)
        if field.name in _OF_THE_SOLUTION and value != fixed:
            raise refuse(field.name, value, f"{fixed}, as the solution has it")
        values[section][field.attribute] = value
    sections: dict[str, Any] = {name: kind(**values[name]) for name, kind in SECTIONS.items()}
    return Settings(**sections, **values[""])


def _sets(override: str) -> set[tuple[str, str]]:
    """The (section, attribute) pairs that one override sets."""
    key = override.split("=", 1)[0].lstrip("+~").split("@")[0]
    if key.split(".")[0] in ("solution", "deployments", "hydra") or key.startswith("hydra/"):
        return set()
    if key in _GROUPS:
        section = "rules" if key == "grammar" else "world"
        return {(section, attribute) for attribute in _GROUPS[key]}
    if key in SECTIONS:
        return {(section, field.attribute) for section, field in settings_fields() if section == key}
    paths = accepted_paths()
    if key not in paths:
        raise unknown_setting(key)
    if key == "world.file":  # and its text, which was read when the file was named
        return {("world", "file"), ("world", "content")}
    return {paths[key]}


def take(config: Mapping[str, Any], *names: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """A configuration without some top-level entries, and those entries. Raises InputError if one is missing."""
    for name in names:
        if name not in config:
            raise InputError(f"{name}: has no default; accepted is {name}=VALUE")
    return {key: value for key, value in config.items() if key not in names}, {name: config[name] for name in names}
