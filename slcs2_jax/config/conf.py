"""conf/: choices under a name (environments, ranges, grammars, searches, experiments), each a YAML file in a group."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config.errors import InputError


def conf_dir() -> Path:
    """The folder conf/: inside the package when installed from a wheel, beside it in a checkout.

    Raises InputError if there is none.
    """
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "conf", package.parent / "conf"):
        if (folder / "environment").is_dir():
            return folder
    raise InputError(f"conf={package / 'conf'}: not found; accepted is an installation with the project's conf folder")


def groups() -> dict[str, list[str]]:
    """The groups of conf/ and their options."""
    return {folder.name: options(folder) for folder in sorted(conf_dir().iterdir()) if folder.is_dir()}


def options(group: Path) -> list[str]:
    """The options in the folder of a group; none if there is no such folder."""
    return sorted(file.stem for file in group.glob("*.yaml"))


def choices(group: str, names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """What each of these options of a group sets."""
    import yaml

    folder = conf_dir() / group
    return {name: yaml.safe_load((folder / f"{name}.yaml").read_text(encoding="utf-8")) for name in names}
