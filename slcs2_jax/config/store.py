"""The settings as Hydra's structured store: the dataclass fields make the configuration that each command composes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from slcs2_jax.config.field import Described
from slcs2_jax.config.schema import plain_value, settings_fields
from slcs2_jax.config.settings import SECTIONS, Settings

# Groups whose name is also what a user types for the setting that their options set: a value that is no option is that
# setting's, such as the path of a grammar or a search that a plug-in brings.
BY_VALUE = {"grammar": "rules.grammar", "search": "search.name"}
CHOICES = {"environment": "open", "range": "short", "grammar": "main", "search": "slcs2"}

# Hydra writes nothing of its own: the run folder is run_dir, and the console is the program's.
_HYDRA: dict[str, Any] = {"output_subdir": None, "run": {"dir": "."}, "job": {"chdir": False}}
_HYDRA_GROUPS = {"launcher": "batched", "job_logging": "none", "hydra_logging": "none"}


@dataclass(frozen=True, kw_only=True)
class Primary:
    """What a command composes its settings from.

    Attributes:
        name: the command's, for Hydra and for messages.
        settings: values unless the command line says otherwise.
        choices: options of groups in conf/ that apply unless others are chosen; None for none.
        own: entries that are the command's and no settings, with their defaults.
        open: of these, the ones that the user may fill freely; their defaults are options of the group `last`.
        last: a group that may set everything before it, and its option.
        left_out: sections that the command has no use for.
        hydra: entries of Hydra's own node.
    """

    name: str
    settings: Settings = field(default_factory=Settings)
    choices: Mapping[str, str | None] = field(default_factory=lambda: dict(CHOICES))
    own: Mapping[str, Any] = field(default_factory=dict)
    open: Sequence[str] = ()
    last: tuple[str, str] | None = None
    left_out: Sequence[str] = ()
    hydra: Mapping[str, Any] = field(default_factory=dict)

    def fields(self) -> Iterator[tuple[str, str, Described]]:
        """(path in the composed configuration, section, field) of every setting the command takes."""
        for section, one in settings_fields():
            if section not in self.left_out:
                yield compose_path(section, one), section, one

    def groups(self) -> dict[str, str | None]:
        """Groups and the options that apply unless others are chosen; None: a place for options of the user's."""
        places: dict[str, str | None] = dict.fromkeys(name for name in SECTIONS if name not in self.left_out)
        return places | dict(self.choices) | dict([self.last] if self.last else [])

    def node(self, search_path: Sequence[str] = ()) -> dict[str, Any]:
        """The configuration with its list of defaults, as Hydra takes it; `search_path` has further folders' URLs."""
        node: dict[str, Any] = {
            "defaults": [
                "_self_",
                *({group: option} for group, option in self.groups().items()),
                *({f"override hydra/{group}": option} for group, option in _HYDRA_GROUPS.items()),
            ],
            "hydra": {**_HYDRA, **self.hydra, "searchpath": list(search_path)},
            **self.own,
        }
        for path, section, one in self.fields():
            place = node
            *parents, last = path.split(".")
            for parent in parents:
                place = place.setdefault(parent, {})
            value = getattr(getattr(self.settings, section) if section else self.settings, one.attribute)
            place[last] = _literally(plain_value(value))
        return node


def _literally(value: Any) -> Any:
    """The value such that Hydra takes it as it is: texts may come from files, and `${...}` in them means nothing."""
    if isinstance(value, list):
        return [_literally(entry) for entry in value]
    return re.sub(r"(\\*)\$\{", r"\1\1\\${", value) if isinstance(value, str) else value


def compose_path(section: str, field: Described) -> str:
    """Where a setting stands in the composed configuration: under its name, unless that is the name of a group."""
    return f"{section}.{field.attribute}" if field.name in CHOICES else field.name
