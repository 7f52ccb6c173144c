"""Between nested plain mappings, as a configuration file holds them, and typed settings.

A mapping uses the names a user types: `radio: {noise_dbm: ...}` for most settings and top-level names for the few that
have one (`generations`, `grammar`, `environment`, ...). Inside their section those are understood too
(`rules: {grammar: ...}`), because that is where the groups of conf/ put them.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from slcs2_jax.config import plugins
from slcs2_jax.config.errors import InputError, refuse, show
from slcs2_jax.config.field import Described, described
from slcs2_jax.config.settings import SECTIONS, Settings


def settings_fields() -> Iterator[tuple[str, Described]]:
    """(section name, field) of every setting in the order of the dataclasses; the section name of a run's own is ""."""
    for section, kind in SECTIONS.items():
        for field in described(kind):
            yield section, field
    for field in described(Settings):
        yield "", field


def accepted_paths() -> dict[str, tuple[str, str]]:
    """Every accepted dotted path, and the (section, attribute) it sets."""
    paths: dict[str, tuple[str, str]] = {}
    for section, field in settings_fields():
        target = (section, field.attribute)
        paths[field.name] = target
        if section:
            paths[f"{section}.{field.attribute}"] = target
    return paths


def flatten(mapping: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Dotted paths and their values; a section given as something else than a mapping stays, to be refused, and so does
    an empty mapping in the place of a setting."""
    flat: dict[str, Any] = {}
    for key, value in mapping.items():
        path = f"{prefix}{key}"
        if isinstance(value, Mapping) and (value or path in SECTIONS):
            flat.update(flatten(value, path + "."))
        else:
            flat[path] = value
    return flat


def unknown_setting(path: str) -> InputError:
    """The error for a name that is no setting, with the nearest names that are."""
    names = sorted(accepted_paths())
    near = difflib.get_close_matches(path, names, n=3, cutoff=0.5)
    if not near:  # the right name in the wrong section is the commonest slip
        last = path.rsplit(".", 1)[-1]
        near = [name for name in names if difflib.SequenceMatcher(None, name.rsplit(".", 1)[-1], last).ratio() > 0.8][
            :3
        ]
    accepts = f"did you mean {' or '.join(near)}?" if near else f"accepted are settings of {', '.join(SECTIONS)}"
    return InputError(f"{show(path)}: no such setting; {accepts} (slcs2 evolve --help lists all)")


def settings_from(mapping: Mapping[str, Any]) -> Settings:
    """Settings from a nested mapping; what is missing keeps its default. Raises InputError naming the field.

    A setting may stand under both of its names only with one value. Plug-ins that the mapping names must be loaded: it
    may come from a file, which imports nothing (PluginError).
    """
    if not isinstance(mapping, Mapping):
        raise refuse("settings", mapping, "a mapping of settings")
    plugins.check_named(mapping.get(plugins.SETTING), plugins.SETTING)  # first: they bring names that settings have
    paths = accepted_paths()
    found: dict[tuple[str, str], Any] = {}
    for path, value in flatten(mapping).items():
        if path in SECTIONS:
            raise refuse(path, value, f"a group of settings such as {path}.{next(described(SECTIONS[path])).attribute}")
        if path not in paths:
            raise unknown_setting(path)
        target = paths[path]
        if target in found and found[target] != value:
            raise refuse(path, value, f"one value for one setting, and it is also given as {show(found[target])}")
        found[target] = value
    sections: dict[str, Any] = {
        name: kind(**{attribute: value for (section, attribute), value in found.items() if section == name})
        for name, kind in SECTIONS.items()
    }
    own: dict[str, Any] = {attribute: value for (section, attribute), value in found.items() if not section}
    return Settings(**sections, **own)


def settings_to_dict(settings: Settings) -> dict[str, Any]:
    """A nested dict of plain values that `settings_from` turns into equal settings."""
    nested: dict[str, Any] = {}
    for section, field in settings_fields():
        value = getattr(getattr(settings, section) if section else settings, field.attribute)
        place = nested
        *parents, last = field.name.split(".")
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = plain_value(value)
    return nested


def plain_value(value: Any) -> Any:
    """A setting's value as files and Hydra have it."""
    return list(value) if isinstance(value, tuple) else value
