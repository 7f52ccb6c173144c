"""What resume and repeat read from their arguments: a folder, and the few settings that may be changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from slcs2_jax.config import Settings


def folder_and_changes(command: str, arguments: Sequence[str], accepted: Sequence[str]) -> tuple[str, dict[str, Any]]:
    """The folder and the values of the settings that are given. Raises InputError if one of them is not accepted."""
    from slcs2_jax.config.yaml_text import parse_yaml

    folders = [argument for argument in arguments if "=" not in argument]
    if len(folders) != 1 or folders[0].startswith("-"):
        raise InputError(f"{command}: accepted is slcs2 {command} FOLDER [setting=value ...] (slcs2 {command} --help)")
    changes: dict[str, Any] = {}
    for argument in arguments:
        name, equals, text = argument.partition("=")
        if not equals:
            continue
        if name not in accepted:
            raise refuse("setting", name, "one of " + ", ".join(accepted) + "; the rest stays as the run began")
        try:
            changes[name] = parse_yaml(text)
        except InputError:
            raise refuse(name, text, "a number, a text, true, false or null") from None
    return folders[0], changes


def changed(settings: Settings, changes: Mapping[str, Any]) -> Settings:
    """The settings with some values changed. Raises InputError naming one that is not accepted."""
    from slcs2_jax.config import settings_from, settings_to_dict

    plain = settings_to_dict(settings)
    for name, value in changes.items():
        section, _, last = name.rpartition(".")
        (plain[section] if section else plain)[last] = value
    return settings_from(plain)
