"""slcs2 report: a page to look at, of a run or of all runs below a folder; of these also what they come to."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.looked_at import look_into, told_apart
from slcs2_jax.config.door import present
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.field import refuse

if TYPE_CHECKING:
    from slcs2_jax.results import FinishedRun
    from slcs2_jax.study.report import Report

TAKES_SETTINGS = False
HELP = """\
slcs2 report RUN [option=value ...]: a run as one HTML page that needs no network, RUN/report.html
slcs2 report FOLDER [option=value ...]: all runs in a folder and below it as such a page; and tables, figures and
verdicts, in FOLDER/report

The page has the course of every search; of the best instances also their rules and a replay, to play and to scrub.

  replays=4         instances with rules and a replay: the best of each algorithm in each world first
  deployment=0      which of the fresh deployments is replayed
  out=PATH          where to: of a RUN a file .html, of a FOLDER a folder. An earlier report there is replaced
  generations=N     of a FOLDER: compare after so many; without it, after as many as all runs of an experiment have
  strict=off        on: exit code 3 if anything was passed over
Of a folder, report.md has everything; runs.csv has a row for each run; there are a CSV for each table, tables.tex,
figures as PNG and SVG, and verdicts.md and verdicts.json: each claim of the paper with what these runs say of it.
Only instances and generations that all arms have are compared; what is missing is listed. Links to folders are not
followed. Whatever is passed over is named, and why, on stderr.
"""
_DEFAULTS: dict[str, Any] = {"replays": 4, "deployment": 0, "out": None, "generations": None, "strict": False}
OPTIONS = tuple(_DEFAULTS)
_PASSED_OVER = 3


def run(arguments: list[str]) -> int:
    """Report on what the arguments name."""
    folders, options, others = told_apart(arguments, _DEFAULTS)
    if len(folders) != 1:
        raise InputError(f"report: {len(folders)} folders; accepted is slcs2 report FOLDER [option=value ...]")
    if others:
        raise refuse("setting", others[0].partition("=")[0], "one of " + ", ".join(_DEFAULTS))
    generations = options["generations"]
    if generations is not None and not (generations.isdecimal() and int(generations) > 0):
        raise refuse("generations", generations, "a whole number >= 1")
    from slcs2_jax.results.run_config import CONFIG

    folder = Path(folders[0])
    passed: list[str] = []
    if present(folder / CONFIG):
        _report_on_run(folder, options, passed)
    else:
        place = report_on(folders[0], options["out"], None if generations is None else int(generations), passed)
        from slcs2_jax.looking.page_entries import runs_of_evolution

        runs = runs_of_evolution(folder)
        if runs:
            from slcs2_jax.looking.page import PAGE

            _write_page(place / PAGE, f"Runs in {folder.resolve().name}", runs, options, passed)
    return _PASSED_OVER if passed and options["strict"] else 0


def _report_on_run(folder: Path, options: dict[str, Any], passed: list[str]) -> None:
    from slcs2_jax.looking.page import PAGE, is_page

    if options["generations"] is not None:
        raise InputError("generations: not for a run; accepted is a folder of runs, or no such setting")
    path = folder / PAGE if options["out"] is None else Path(options["out"])
    if path.suffix != ".html" or not path.parent.is_dir():
        raise refuse("out", str(path), "a file .html in a folder that exists")
    if present(path) and not is_page(path):
        raise InputError(f"out={path}: exists and is no page of a run; accepted is a new file, or an earlier page")
    one = look_into(str(folder))
    _write_page(path, f"Run {folder.resolve().name}", [one], options, passed)


def _write_page(path: Path, title: str, runs: list[FinishedRun], options: dict[str, Any], passed: list[str]) -> None:
    """Write the page, and say what was passed over."""
    from slcs2_jax.looking.page import write_page
    from slcs2_jax.looking.page_entries import entries
    from slcs2_jax.results.progress import counting

    unread: list[str] = []
    with counting("replay: time-step") as count:
        shown = entries(
            runs, replays=options["replays"], deployment=options["deployment"], after_chunk=count, passed=unread
        )
        write_page(path, title, shown)
    print_passed(unread)
    passed += unread
    print(f"page {terminal(str(path))}", flush=True)


def print_passed(passed: Sequence[str]) -> None:
    """Say on stderr what was passed over, and why."""
    for line in passed:
        print(f"passed over: {terminal(line)}", file=sys.stderr)


def report_on(
    folder: str, out: str | None = None, generations: int | None = None, passed: list[str] | None = None
) -> Path:
    """Write tables, figures and verdicts; print where they are, what is missing, and the verdicts. The folder.

    `passed` gets a line for each folder that was passed over; they are printed, too.
    """
    try:
        from slcs2_jax.study.report import write_report
    except ImportError as error:
        raise InputError(
            f"report: {error.name} is not installed; accepted is an installation with slcs2_jax[analysis]"
        ) from None
    passed = [] if passed is None else passed
    report = write_report(folder, out, generations, passed)
    print_passed(passed)
    print_report(report)
    return report.folder


def print_report(report: Report) -> None:
    """A few lines on the terminal."""
    from slcs2_jax.study.study import BEST

    for study in report.studies:
        print(f"{terminal(study.title)}: after {study.generations} generations")
        for line in _first(study.missing, 8):
            print(f"  missing: {terminal(line)}")
    for finding in report.findings:
        if finding.metric == BEST and finding.evidence[0].count:
            print(f"{finding.verdict:>18}  {finding.claim.says}")
    print(f"report {terminal(str(Path(report.folder) / 'report.md'))}", flush=True)


def _first(lines: Sequence[str], count: int) -> list[str]:
    rest = len(lines) - count
    return [*lines[:count], f"and {rest} more, see the report"] if rest > 0 else list(lines)
