"""slcs2 resume: interrupted runs go on; finished ones go further if more generations are asked for."""

from __future__ import annotations

import sys

from slcs2_jax.commands.advance import advance
from slcs2_jax.commands.changes import changed, folder_and_changes
from slcs2_jax.commands.report import print_passed

TAKES_SETTINGS = False
HELP = """\
slcs2 resume FOLDER [setting=value ...]: go on with the run in FOLDER, or with all runs of the sweep or folder FOLDER

Every run that was interrupted goes on from where it was saved, all of them in one batch, and ends with the same bytes
in its results as if it had never been interrupted. Repeating the command that started them does the same.

  plugins=[MODULE]      those that the runs were begun with, if any
  generations=N         go further than was asked for before: the same as if N generations had been asked for at once
  compute.devices=N     what of the machine is used now: devices and cache; nothing else of a run can be changed
  checkpoint.seconds=S  how often runs are saved from now on: seconds and generations
  logger=NAME           who is told from now on; none unless it is named again
Exit code: 0 done, 1 the disk refused, 2 bad input (one line says what), 130 or 143 interrupted again.
"""
OPTIONS = (
    "generations",
    "compute.devices",
    "compute.cache",
    "checkpoint.seconds",
    "checkpoint.generations",
    "logger",
)


def run(arguments: list[str]) -> int:
    """Go on with what is below the folder."""
    folder, changes = folder_and_changes("resume", arguments, OPTIONS)
    from slcs2_jax.results.sweep import runs_below

    passed: list[str] = []
    settings, others = runs_below(folder, passed)
    print_passed(passed)
    if others:
        print(f"{others} evaluations are left alone: the command that began one repeats it", file=sys.stderr)
    if settings:
        # a folder may be a stranger's: it tells nobody unless the user says so
        advance([changed(one, {"logger": "none", **changes}) for one in settings], as_begun=True)
    return 0
