"""slcs2 report: what the runs below a folder come to, and what that says of the paper's claims."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from slcs2_jax.analysis.report import Report

TAKES_SETTINGS = False
HELP = """\
slcs2 report FOLDER [generations=N] [out=DIR]: tables, figures and verdicts from the runs in a folder and below it

  FOLDER            of an experiment, or any folder with run folders in it
  generations=N     compare after N generations; without it, after as many as all runs of an experiment have
  out=DIR           where the report goes; without it, FOLDER/report
Writes report.md with everything, runs.csv (one row per run), a CSV for each table, tables.tex, figures as PNG and SVG,
and verdicts.md and verdicts.json: each claim of the paper with what these runs say of it.
Only instances and generations that all arms have are compared; what is missing is listed.
"""


def run(arguments: list[str]) -> int:
    """Report on what the arguments name."""
    folders = [argument for argument in arguments if "=" not in argument]
    if len(folders) != 1 or folders[0].startswith("-"):
        raise InputError(f"report: {len(folders)} folders; accepted is slcs2 report FOLDER [generations=N] [out=DIR]")
    given = dict(argument.split("=", 1) for argument in arguments if "=" in argument)
    for name in given:
        if name not in ("generations", "out"):
            raise refuse("setting", name, "one of generations, out")
    generations = given.get("generations")
    if generations is not None and not (generations.isdecimal() and int(generations) > 0):
        raise refuse("generations", generations, "a whole number >= 1")
    report_on(folders[0], given.get("out"), None if generations is None else int(generations))
    return 0


def report_on(folder: str, out: str | None = None, generations: int | None = None) -> None:
    """Write the report and print where it is, what is missing, and the verdicts."""
    try:
        from slcs2_jax.analysis.report import write_report
    except ImportError as error:
        raise InputError(
            f"report: {error.name} is not installed; accepted is an installation with slcs2_jax[analysis]"
        ) from None
    print_report(write_report(folder, out, generations))


def print_report(report: Report) -> None:
    """A few lines on the terminal."""
    from slcs2_jax.analysis.study import BEST

    for study in report.studies:
        print(f"{study.title}: after {study.generations} generations")
        for line in _first(study.missing, 8):
            print(f"  missing: {line}")
    for finding in report.findings:
        if finding.metric == BEST and finding.evidence[0].count:
            print(f"{finding.verdict:>18}  {finding.claim.says}")
    print(f"report {Path(report.folder) / 'report.md'}", flush=True)


def _first(lines: Sequence[str], count: int) -> list[str]:
    rest = len(lines) - count
    return [*lines[:count], f"and {rest} more, see the report"] if rest > 0 else list(lines)
