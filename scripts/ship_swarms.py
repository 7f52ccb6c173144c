"""The swarms that come with the package: python scripts/ship_swarms.py ROOT.

Of every world and grammar among the finished runs below ROOT, the winner with the greatest mean over its fresh
deployments goes to slcs2_jax/swarms, by its world's name. It is the best of all that search there found, for showing:
what a search finds in the mean is told by the report.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import NamedTuple

from slcs2_jax.config import InputError
from slcs2_jax.config.door import read_file
from slcs2_jax.results import read_run
from slcs2_jax.results.files import names_in
from slcs2_jax.results.run_folder import SOLUTIONS, folders_with_config
from slcs2_jax.results.swarms import FOLDER

_LARGEST = 2**24  # bytes of a solution that ships


class Found(NamedTuple):
    """A winner: its mean over fresh deployments, and its file."""

    fresh: float
    file: Path


def winners(root: Path) -> dict[str, Found]:
    """The best of each world and grammar by the name that it gets."""
    best: dict[str, Found] = {}
    for folder in folders_with_config(root):
        run = read_run(folder)
        world, grammar = run.settings.world, run.settings.rules.grammar
        name = f"{world.range}_{world.environment}" + (f"_{grammar}" if grammar != "main" else "")
        for number, instance in enumerate((run.summary or {}).get("instances", [])):
            file = folder / SOLUTIONS / f"instance_{number:03d}_best.npz"
            if file.name in names_in(folder / SOLUTIONS, inside=folder):
                best[name] = max(best.get(name, Found(-1.0, file)), Found(instance["fresh_mean"], file))
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path, help="folder of an experiment, or any with runs below it")
    arguments = parser.parse_args()
    if not arguments.root.is_dir():
        raise InputError(f"root={arguments.root}: no such folder; accepted is one with runs of slcs2")
    for name, found in sorted(winners(arguments.root).items()):
        (FOLDER / f"{name}.npz").write_bytes(read_file(found.file, _LARGEST, inside=found.file.parents[1]))
        print(f"{name}: {found.fresh:.3f}, {found.file.relative_to(arguments.root)}")


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"ship_swarms: error: {error}")
