"""Runs of an archive made again: python scripts/repeat_runs.py RUNS.tar.bz2 [--count 10] [--seed 0].

Picks finished searches of an archive (scripts/archive_runs.py) by chance, makes each again with `slcs2 repeat`, and
says which came to the same bytes. Exit code 0 if all did.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

from slcs2_jax.results import read_run
from slcs2_jax.results.run_config import read_config
from slcs2_jax.results.run_folder import folders_with_config


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("archive", type=Path, help="of runs, .tar.bz2 or .tar.xz")
    parser.add_argument("--count", type=int, default=10, help="runs")
    parser.add_argument("--seed", type=int, default=0, help="of the chance")
    arguments = parser.parse_args()
    if not arguments.archive.is_file():
        sys.exit(f"repeat_runs: error: archive={arguments.archive}: no such file; accepted is an archive of runs")
    with tempfile.TemporaryDirectory(prefix="slcs2-repeat-") as scratch:
        with tarfile.open(arguments.archive) as archive:
            archive.extractall(scratch, filter="data")
        searches = [
            folder
            for folder in sorted(folders_with_config(Path(scratch)))
            if read_config(folder).evolves and read_run(folder).summary is not None
        ]
        picked = random.Random(arguments.seed).sample(searches, min(arguments.count, len(searches)))
        same = [repeated(folder, folder.relative_to(scratch)) for folder in picked]
    print(f"{sum(same)} of {len(same)} came to the same bytes")
    return 0 if all(same) else 1


def repeated(folder: Path, name: Path) -> bool:
    """Whether a run comes to the same again."""
    done = subprocess.run(
        [sys.executable, "-m", "slcs2_jax", "repeat", str(folder)], capture_output=True, text=True, check=False
    )
    lines = done.stdout.splitlines() or done.stderr.splitlines() or ["nothing was said"]
    print(f"{name}: {lines[-1]}", flush=True)
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
