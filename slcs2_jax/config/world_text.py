"""The text of a world's file: read once, when the user names the file, and kept with the settings from then on.

A run folder that comes from elsewhere can so never make this program read a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slcs2_jax.config.door import read_file
from slcs2_jax.config.errors import InputError, refuse, show

LARGEST = 2**18  # bytes of a world's file, some thousands of walls
SUFFIXES = (".yaml", ".yml")


def read_world(path: str | Path) -> str:
    """The text of a world's file. Raises InputError naming it if it is no file, too large, or no text."""
    accepts = f"the path of a YAML file of at most {LARGEST} bytes"
    if not isinstance(path, str | Path) or "\0" in str(path):
        raise refuse("world.file", path, accepts)
    try:
        text = read_file(Path(path), LARGEST).decode("utf-8")
    except (InputError, OSError, UnicodeDecodeError) as error:
        raise InputError(f"world.file={show(str(path))}: {show(str(error))}; accepted is {accepts}") from None
    if not text.strip():
        raise refuse("world.file", str(path), accepts)
    return text


def by_path(argument: str) -> str:
    """`world=some/file.yaml` as the override that it stands for, `world.file=...`; any other argument as it is."""
    key, equals, value = argument.partition("=")
    is_file = equals and value.strip("'\"").endswith(SUFFIXES)
    return f"world.file={value}" if key == "world" and is_file else argument


def with_world_text(config: Mapping[str, Any]) -> dict[str, Any]:
    """A composed configuration with the text of the world's file that it names, if it names one."""
    world = config.get("world")
    if not isinstance(world, Mapping) or world.get("file") is None or world.get("content") is not None:
        return dict(config)
    return {**config, "world": {**world, "content": read_world(world["file"])}}
