"""What slcs2 replay shows with suite=WORLD: entries of the benchmark side by side in one of its worlds."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.commands.replay import Compute

ROOT = "runs/suite"  # where slcs2 suite keeps artefacts unless it is told otherwise
_SETTINGS = ("seed=", "compute.", "run_dir=")


def check(options: dict[str, Any], subjects: Sequence[str], assignments: Sequence[str]) -> None:
    """Refuse what does not go with suite=. Raises InputError."""
    from slcs2_jax.suite.worlds import load_suite

    load_suite().world(options["suite"])
    if bool(subjects) == (options["policy"] is not None):
        raise InputError("replay: accepted is slcs2 replay ENTRY suite=WORLD beside=ENTRY (slcs2 suite list)")
    for one in assignments:
        if not one.startswith(_SETTINGS):
            raise refuse("setting", one.partition("=")[0], "seed, run_dir or compute.*: the suite's worlds are frozen")


def first_seed(name: str) -> int:
    """The seed that is shown unless another is asked for: that of the first validation world."""
    from slcs2_jax.suite.worlds import load_suite

    return load_suite().world(name).seeds_of("validation")[0]


def episodes(options: dict[str, Any], subjects: Sequence[str], config: dict[str, Any]) -> list[tuple[str, Compute]]:
    """Titles, and how each is computed, as `replay` has them. Raises InputError."""
    import dataclasses

    from slcs2_jax.config import settings_from
    from slcs2_jax.looking.solutions import replay
    from slcs2_jax.suite.deployed import ready
    from slcs2_jax.suite.entries import entry_named
    from slcs2_jax.suite.measured import shipped_root
    from slcs2_jax.suite.worlds import load_suite

    world = load_suite().world(options["suite"])
    world.check()
    seed, root = int(config["seed"]), Path(config["run_dir"] or ROOT)
    world.split_of(seed)
    compute = settings_from({"compute": config["compute"]}).compute
    steps = None if options["end"] == "auto" else int(options["end"])
    found: list[tuple[str, Compute]] = []
    for name in (*subjects, options["policy"], options["beside"]):
        if name is None:
            continue
        entry = entry_named(name)
        shown = ready(entry, world, seed, (root, shipped_root()), (options["training"],))
        settings = dataclasses.replace(shown.settings, compute=compute)
        place = {"seed": seed, "deployment": options["deployment"], "steps": steps}
        found.append(
            (f"{terminal(entry.title)} in {world.name}", partial(replay, shown.policies[0], settings, **place))
        )
    return found
