"""slcs2 report: a page to look at, of a run or of all runs below a folder; of these also what they come to."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

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
slcs2 report FOLDER [option=value ...]: what all runs in a folder and below it come to, in FOLDER/report: a page,
tables, figures, and verdicts on the paper's claims

FOLDER may hold experiments of the paper (slcs2 experiment), a sweep over any settings (slcs2 evolve -m), or both.

  replays=4         instances with rules and a replay: the best of each algorithm in each world first
  deployment=0      which of the fresh deployments is replayed
  out=PATH          where to: of a RUN a file .html, of a FOLDER a folder. An earlier report there is replaced
  generations=N     of a FOLDER: compare after so many; without it, after as many as all runs of an experiment have
  strict=off        on: exit code 3 if anything was passed over
Of a folder, report.html compares all runs and links a page for each; report.md says what made the runs and in what
they differ, and a page *_report.md for each experiment has the rest in print: figures, comparisons, verdicts, how
results respond to each setting and to two together; runs.csv has a row for each run; there are a CSV for each table,
tables.tex, figures as PNG and SVG, and verdicts.md and verdicts.json: each claim of the paper with what these runs say
of it. Only instances and generations that all arms have are compared; what is missing is listed. Links to folders are
not followed. Whatever is passed over is named, and why, on stderr.
"""
PAGES = "runs"  # folder of the runs' pages, below the report's
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
        count = None if generations is None else int(generations)
        report = report_on(folders[0], options["out"], count, passed)
        _write_pages(folder, report, options, passed)
    return _PASSED_OVER if passed and options["strict"] else 0


def _report_on_run(folder: Path, options: dict[str, Any], passed: list[str]) -> None:
    from slcs2_jax.looking.document import is_page
    from slcs2_jax.looking.page import PAGE
    from slcs2_jax.looking.page_entries import chosen

    if options["generations"] is not None:
        raise InputError("generations: not for a run; accepted is a folder of runs, or no such setting")
    path = folder / PAGE if options["out"] is None else Path(options["out"])
    if path.suffix != ".html" or not path.parent.is_dir():
        raise refuse("out", str(path), "a file .html in a folder that exists")
    if present(path) and not is_page(path):
        raise InputError(f"out={path}: exists and is no page of a run; accepted is a new file, or an earlier page")
    one = look_into(str(folder))
    _write_run(path, one, chosen([one], options["replays"]), options["deployment"], passed)
    print(f"page {terminal(str(path))}", flush=True)


def _write_pages(folder: Path, report: Report, options: dict[str, Any], passed: list[str]) -> None:
    """The page of all runs, and one for each run of evolution, which it links."""
    from slcs2_jax.looking.page import PAGE
    from slcs2_jax.looking.page_entries import chosen, runs_of_evolution
    from slcs2_jax.results.files import make_folder
    from slcs2_jax.study.page import write_study_page

    make_folder(report.folder / PAGES, inside=report.folder)
    _remove_pages(report.folder / PAGES)
    runs = runs_of_evolution(folder)
    replayed = chosen(runs, options["replays"])
    pages = {}
    for run in runs:
        address = (Path(PAGES) / (run.path.relative_to(folder).as_posix() + ".html")).as_posix()
        path = report.folder / address
        for folder_above in reversed(path.relative_to(report.folder).parents[:-1]):
            make_folder(report.folder / folder_above, inside=report.folder)
        _write_run(path, run, replayed, options["deployment"], passed)
        for instance in range(run.settings.instances):
            pages[run.path, instance] = (quote(address), (run.path, instance) in replayed)
    write_study_page(report.folder / PAGE, f"Runs in {folder.resolve().name}", report, pages)
    print(f"page {terminal(str(report.folder / PAGE))}", flush=True)


def _write_run(
    path: Path, run: FinishedRun, replayed: list[tuple[Path, int]], deployment: int, passed: list[str]
) -> None:
    """Write the page, and say what was passed over."""
    from slcs2_jax.looking.page import write_page
    from slcs2_jax.looking.page_entries import entries
    from slcs2_jax.results.progress import counting

    unread: list[str] = []
    with counting("replay: time-step") as count:
        shown = entries(run, replayed=replayed, deployment=deployment, after_chunk=count, passed=unread)
        write_page(path, f"Run {run.path.resolve().name}", shown)
    print_passed(unread)
    passed += unread


def _remove_pages(folder: Path) -> None:
    """Those of an earlier report: of runs that may be gone."""
    from slcs2_jax.config.door import folders_below
    from slcs2_jax.looking.document import is_page

    for place in list(folders_below(folder)):
        for path in sorted(place.glob("*.html")):
            if is_page(path):
                path.unlink()


def print_passed(passed: Sequence[str]) -> None:
    """Say on stderr what was passed over, and why."""
    for line in passed:
        print(f"passed over: {terminal(line)}", file=sys.stderr)


def report_on(
    folder: str, out: str | None = None, generations: int | None = None, passed: list[str] | None = None
) -> Report:
    """Write tables, figures and verdicts; print where they are, what is missing, and the verdicts.

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
    return report


def print_report(report: Report) -> None:
    """A few lines on the terminal."""
    from slcs2_jax.study.study import BEST, FRESH

    for study in report.studies:
        print(f"{terminal(study.title)}: {study.when}")
        for line in _first(study.missing, 8):
            print(f"  missing: {terminal(line)}")
    told: dict[str, dict[str, str]] = {}
    for finding in report.findings:
        if finding.evidence[0].count:
            told.setdefault(finding.claim.says, {})[finding.metric] = finding.verdict
    if told:
        print(f"{'by fresh means':>18} {'by best fitness':>18}")
    for says, verdicts in told.items():
        print(f"{verdicts.get(FRESH, '-'):>18} {verdicts.get(BEST, '-'):>18}  {says}")
    print(f"report {terminal(str(Path(report.folder) / 'report.md'))}", flush=True)


def _first(lines: Sequence[str], count: int) -> list[str]:
    rest = len(lines) - count
    return [*lines[:count], f"and {rest} more, see the report"] if rest > 0 else list(lines)
