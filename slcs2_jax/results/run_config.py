"""config.yaml: the settings of a run and the record of how it was made, for people to read, with a checksum."""

from __future__ import annotations

import copy
import functools
import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from slcs2_jax import __version__
from slcs2_jax.config import InputError, Settings, invocation, plugins, settings_from, settings_to_dict
from slcs2_jax.config.door import present, read_file, telling_damage
from slcs2_jax.config.field import show
from slcs2_jax.config.registry import any_name
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.config.yaml_text import MOST_BYTES, parse_yaml
from slcs2_jax.results.documents import check_format, check_sum, checksum
from slcs2_jax.results.files import storing, write_text

CONFIG = "config.yaml"
FORMAT = "slcs2_jax run 1"
_ONCE_THE_ONLY_ONE = "Search"  # in records of versions whose settings did not name the search

# What may differ when a run goes on: where it lies, how far it goes, how much of the machine it uses, when it is saved,
# who is told.
# Slots and chunk may not: they decide the last bits of the arithmetic.
_FREE = ("run_dir", "generations", "compute.devices", "compute.cache", "logger")
_FREE_SECTIONS = ("checkpoint",)
_LONGEST = 2**16  # letters of a command in the record


@dataclass(frozen=True)
class RunConfig:
    """The settings of a run, and when, by which command, with which device and versions it was made."""

    settings: Settings
    record: dict[str, Any]

    @property
    def evolves(self) -> bool:
        """Is this a run of evolution (and not an evaluation)?"""
        return self.record.get("kind") == "evolve"

    def changes(self, device: str) -> str:
        """In words, what decides the last bits and is not as it was when the run was begun; "" if nothing is."""
        before = {**self.record.get("versions", {}), "device": _kind(self.record.get("device", ""))}
        now = {**versions(), "device": _kind(device)}
        return ", ".join(
            f"{name} was {before.get(name)} and is {value}" for name, value in now.items() if before.get(name) != value
        )


def new_record(kind: str, device: str, more: Mapping[str, Any]) -> dict[str, Any]:
    """The record of a run that starts now; `more` is what only the caller knows."""
    return {
        "format": FORMAT,
        "kind": kind,
        "started": datetime.now().astimezone().isoformat(timespec="seconds"),
        "command": _printable(invocation.command())[:_LONGEST],
        "device": device,
        "versions": versions(),
        **more,
    }


def _kind(device: str) -> str:
    """`2 x cpu (cpu)` without the number of devices, which decides nothing."""
    return device.partition(" x ")[2]


def _printable(text: str) -> str:
    """Without what no text file can hold: arguments may be any bytes."""
    return text.encode("utf-8", "replace").decode("utf-8")


def versions() -> dict[str, str]:
    """Versions of this package, Python, and what decides its results."""
    found = {"slcs2_jax": __version__, "python": platform.python_version()}
    for name in ("jax", "jaxlib", "numpy"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


def write_config(folder: Path, config: RunConfig) -> None:
    """Write config.yaml, whole or not at all. Raises StorageError."""
    import yaml

    content = settings_to_dict(config.settings) | {"record": dict(config.record)}
    content["record"]["checksum"] = checksum(content)
    text = yaml.safe_dump(content, sort_keys=False)
    if len(text) > MOST_BYTES:
        raise InputError(f"{folder / CONFIG}: {len(text):,} letters; accepted are settings of at most {MOST_BYTES:,}")
    write_text(folder / CONFIG, text)


def read_config(folder: Path) -> RunConfig:
    """Read config.yaml.

    Raises InputError naming the file if there is none, or it is damaged or of another program; StorageError.
    """
    file = folder / CONFIG
    label = f"{file}: not the configuration of a run of slcs2"
    if not present(file):
        raise InputError(f"{label} (no such file); accepted is a folder that slcs2 made")
    try:
        with storing(file, "read"):
            data = read_file(file, MOST_BYTES)
    except InputError as error:
        raise InputError(f"{label} ({error}); accepted is a folder that slcs2 made") from None
    try:
        with telling_damage():
            return _from_content(copy.deepcopy(_parsed(data)), file)
    except plugins.PluginError:
        raise
    except InputError as error:
        raise InputError(f"{label} ({show(str(error))}); start the run again in another folder") from None


@functools.lru_cache(maxsize=64)
def _parsed(data: bytes) -> Any:
    """Once for a text: a run is looked for, looked at, locked and continued within moments."""
    return parse_yaml(data)


def _from_content(content: Any, file: Path) -> RunConfig:
    record = dict(content["record"])
    check_format(record.get("format"), FORMAT)
    if record.get("search", _ONCE_THE_ONLY_ONE) != _ONCE_THE_ONLY_ONE:  # its settings do not say so
        raise InputError(f"made by the search {show(str(record['search']))} of an older slcs2_jax: use that one")
    said = record.pop("checksum", None)
    content["record"] = record
    check_sum(content, said)
    del content["record"]
    plugins.check_same(record, str(file))
    with any_name():
        return RunConfig(settings_from(content), record)


def check_same(wanted: Settings, found: Settings, folder: Path) -> None:
    """Raise InputError naming the first setting in which a run that is asked for differs from the one in a folder."""
    for section, field in settings_fields():
        if field.name in _FREE or section in _FREE_SECTIONS:
            continue
        one, other = (getattr(getattr(of, section) if section else of, field.attribute) for of in (wanted, found))
        if one != other:
            raise InputError(
                f"{field.name}={show(one)}: run_dir={show(str(folder))} already holds a run with "
                f"{field.name}={show(other)}; accepted is the same, or another run_dir"
            )
    least = found.search.generations
    if wanted.search.generations < least:
        raise InputError(
            f"generations={wanted.search.generations}: run_dir={show(str(folder))} already holds a run with "
            f"generations={least}; accepted is a whole number from {least}, or another run_dir"
        )


def check_writable(path: str | Path) -> Path:
    """The folder as a Path if it can be made or written to; raises InputError naming it otherwise. Makes nothing."""
    folder = Path(path)
    if _printable(str(path)) != str(path) or "\0" in str(path):
        raise InputError(f"run_dir={_printable(str(path))!r}: accepted is a path that is text")
    label = f"run_dir={show(str(path))}"
    for parent in (folder, *folder.parents):
        if parent.exists():
            if not parent.is_dir():
                raise InputError(f"{label}: {parent} is a file; accepted is a folder that is new or holds no run")
            if not os.access(parent, os.W_OK | os.X_OK):
                raise InputError(f"{label}: {parent} cannot be written to; accepted is a folder that can")
            break
    return folder
