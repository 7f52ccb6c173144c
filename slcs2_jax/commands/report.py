"""slcs2 report: a page to look at, of a run or of all runs below a folder; of these also what they come to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from slcs2_jax.commands.looked_at import look_into, told_apart
from slcs2_jax.config.errors import InputError
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
Of a folder, report.html compares all runs and links a page for each; report.md has everything in print: what differs
between the runs, comparisons, how figures respond to each setting and to two together; runs.csv has a row for each
run; there are a CSV for each table, tables.tex, figures as PNG and SVG, and verdicts.md and verdicts.json: each claim
of the paper with what these runs say of it. Only instances and generations that all arms have are compared; what is
missing is listed.
"""
PAGES = "runs"  # folder of the runs' pages, below the report's
_DEFAULTS: dict[str, Any] = {"replays": 4, "deployment": 0, "out": None, "generations": None}


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
    if (folder / CONFIG).is_file():
        _report_on_run(folder, options)
        return 0
    report = report_on(folders[0], options["out"], None if generations is None else int(generations))
    _write_pages(folder, report, options)
    return 0


def _report_on_run(folder: Path, options: dict[str, Any]) -> None:
    from slcs2_jax.looking.document import is_page
    from slcs2_jax.looking.page import PAGE
    from slcs2_jax.looking.page_entries import chosen

    if options["generations"] is not None:
        raise InputError("generations: not for a run; accepted is a folder of runs, or no such setting")
    path = folder / PAGE if options["out"] is None else Path(options["out"])
    if path.suffix != ".html" or not path.parent.is_dir():
        raise refuse("out", str(path), "a file .html in a folder that exists")
    if path.exists() and not (path.is_file() and is_page(path)):
        raise InputError(f"out={path}: exists and is no page of a run; accepted is a new file, or an earlier page")
    one = look_into(str(folder))
    _write_run(path, one, chosen([one], options["replays"]), options["deployment"])
    print(f"page {path}", flush=True)


def _write_pages(folder: Path, report: Report, options: dict[str, Any]) -> None:
    """The page of all runs, and one for each run of evolution, which it links."""
    from slcs2_jax.looking.page import PAGE
    from slcs2_jax.looking.page_entries import chosen, runs_of_evolution
    from slcs2_jax.study.page import write_study_page

    _remove_pages(report.folder / PAGES)
    runs = runs_of_evolution(folder)
    replayed = chosen(runs, options["replays"])
    pages = {}
    for run in runs:
        address = (Path(PAGES) / (run.path.relative_to(folder).as_posix() + ".html")).as_posix()
        _write_run(report.folder / address, run, replayed, options["deployment"])
        for instance in range(run.settings.instances):
            pages[run.path, instance] = (quote(address), (run.path, instance) in replayed)
    write_study_page(report.folder / PAGE, f"Runs in {folder.resolve().name}", report, pages)
    print(f"page {report.folder / PAGE}", flush=True)


def _write_run(path: Path, run: FinishedRun, replayed: list[tuple[Path, int]], deployment: int) -> None:
    from slcs2_jax.looking.page import write_page
    from slcs2_jax.looking.page_entries import entries
    from slcs2_jax.results.files import storing
    from slcs2_jax.results.progress import counting

    with storing(path.parent, "made"):
        path.parent.mkdir(parents=True, exist_ok=True)
    with counting("replay: time-step") as count:
        shown = entries(run, replayed=replayed, deployment=deployment, after_chunk=count)
        write_page(path, f"Run {run.path.resolve().name}", shown)


def _remove_pages(folder: Path) -> None:
    """Those of an earlier report: of runs that may be gone."""
    from slcs2_jax.looking.document import is_page

    for path in sorted(folder.rglob("*.html")):
        if path.is_file() and is_page(path):
            path.unlink()


def report_on(folder: str, out: str | None = None, generations: int | None = None) -> Report:
    """Write tables, figures and verdicts; print where they are, what is missing, and the verdicts."""
    try:
        from slcs2_jax.study.report import write_report
    except ImportError as error:
        raise InputError(
            f"report: {error.name} is not installed; accepted is an installation with slcs2_jax[analysis]"
        ) from None
    report = write_report(folder, out, generations)
    print_report(report)
    return report


def print_report(report: Report) -> None:
    """A few lines on the terminal."""
    from slcs2_jax.study.study import BEST, FRESH

    for study in report.studies:
        print(f"{study.title}: after {study.generations} generations")
        for line in _first(study.missing, 8):
            print(f"  missing: {line}")
    told: dict[str, dict[str, str]] = {}
    for finding in report.findings:
        if finding.evidence[0].count:
            told.setdefault(finding.claim.says, {})[finding.metric] = finding.verdict
    if told:
        print(f"{'by best fitness':>18} {'by fresh means':>18}")
    for says, verdicts in told.items():
        print(f"{verdicts.get(BEST, '-'):>18} {verdicts.get(FRESH, '-'):>18}  {says}")
    print(f"report {Path(report.folder) / 'report.md'}", flush=True)


def _first(lines: Sequence[str], count: int) -> list[str]:
    rest = len(lines) - count
    return [*lines[:count], f"and {rest} more, see the report"] if rest > 0 else list(lines)
