"""Finished runs in one file: python scripts/archive_runs.py ROOT OUT.tar.bz2.

Of every finished run below ROOT its settings, grammar, knowledge, rows of all generations, summary, times, and winners;
without checkpoints and the rest of the collection. The same runs give the same bytes. Unpacked where ROOT was, `slcs2
report` makes the same report of it, and `slcs2 repeat` any of its runs (scripts/repeat_runs.py: some). What each agent
contributed is nearly half of a packed row, and no report needs it: `--without contribution` leaves it out.
"""

from __future__ import annotations

import argparse
import io
import sys
import tarfile
from collections.abc import Sequence
from pathlib import Path

from slcs2_jax.config import InputError
from slcs2_jax.results import read_run
from slcs2_jax.results.files import names_in
from slcs2_jax.results.rows import read_rows, row_line
from slcs2_jax.results.run_config import CONFIG
from slcs2_jax.results.run_folder import (
    GENERATIONS,
    GRAMMAR,
    KNOWLEDGE,
    SOLUTIONS,
    SUMMARY,
    TIMING,
    folders_with_config,
)

KEPT = (CONFIG, GRAMMAR, KNOWLEDGE, GENERATIONS, SUMMARY, TIMING)
WINNER = "_best.npz"  # ends the name of a winner's file


def files_of(run: Path, winners: Sequence[str] | None) -> list[Path]:
    """What is kept of a run; nothing of one that has not ended. Its winners if a folder above it is one of those."""
    if read_run(run).summary is None:
        return []
    kept = [run / name for name in KEPT if (run / name).is_file()]
    if winners is None or {*winners} & {*run.parts}:
        kept += [run / SOLUTIONS / name for name in names_in(run / SOLUTIONS, inside=run) if name.endswith(WINNER)]
    return sorted(kept)


def plain(member: tarfile.TarInfo) -> tarfile.TarInfo:
    """Without what differs from machine to machine."""
    member.uid = member.gid = member.mtime = 0
    member.uname = member.gname = ""
    member.mode = 0o644
    return member


def thinned(rows: Path, without: Sequence[str]) -> bytes:
    """A file of rows without some of their columns."""
    kept = ({name: value for name, value in row.items() if name not in without} for row in read_rows(rows))
    return b"".join(map(row_line, kept))


def add(archive: tarfile.TarFile, file: Path, name: Path, without: Sequence[str]) -> None:
    """A file, of rows without some of their columns."""
    if not without or file.name != GENERATIONS:
        archive.add(file, name, filter=plain)
        return
    content = thinned(file, without)
    member = archive.gettarinfo(file, str(name))
    member.size = len(content)
    archive.addfile(plain(member), io.BytesIO(content))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path, help="folder of an experiment, or any with runs below it")
    parser.add_argument("out", type=Path, help="file to make, .tar.bz2; replaced if it is there")
    parser.add_argument("--winners", nargs="*", metavar="ARM", help="of these arms alone; of all, if it is left out")
    parser.add_argument("--without", nargs="*", default=[], choices=["contribution"], help="leave it out of the rows")
    arguments = parser.parse_args()
    if not arguments.root.is_dir():
        raise InputError(f"root={arguments.root}: no such folder; accepted is one with runs of slcs2")
    runs = [files for folder in folders_with_config(arguments.root) if (files := files_of(folder, arguments.winners))]
    partial = arguments.out.with_name(arguments.out.name + ".partial")
    with tarfile.open(partial, "w:bz2") as archive:
        for file in (file for files in runs for file in files):
            add(archive, file, file.relative_to(arguments.root.parent), arguments.without)
    partial.replace(arguments.out)
    print(f"{len(runs)} runs, {arguments.out.stat().st_size / 2**20:.2f} MiB: {arguments.out}")


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"archive_runs: error: {error}")
