"""Evolved swarms that come with the package, by name: the best of each world by fresh deployments (docs/results)."""

from __future__ import annotations

from pathlib import Path

from slcs2_jax.config.field import refuse

FOLDER = Path(__file__).resolve().parent.parent / "swarms"


def swarm_names() -> list[str]:
    """Those that there are: RANGE_ENVIRONMENT, with another grammar than main RANGE_ENVIRONMENT_GRAMMAR."""
    return sorted(file.stem for file in FOLDER.glob("*.npz"))


def swarm_file(name: str) -> Path:
    """The saved solution of that name. Raises InputError naming those that there are."""
    if name not in swarm_names():
        raise refuse("swarm", name, "one of " + ", ".join(swarm_names()))
    return FOLDER / f"{name}.npz"
