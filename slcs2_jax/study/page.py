"""The page of a study: one HTML file with verdicts, curves, comparisons and responses, and links to the runs' pages."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from slcs2_jax.looking.document import Blocks, document
from slcs2_jax.results.arm import CELLS, arm_title
from slcs2_jax.results.files import write_text
from slcs2_jax.study.collect import Outcome
from slcs2_jax.study.page_figures import figures
from slcs2_jax.study.report import Report, study_tables
from slcs2_jax.study.report_text import agreement, difference_tables, state_line, work
from slcs2_jax.study.study import METRICS, Study
from slcs2_jax.study.table import Table
from slcs2_jax.study.verdict_text import verdicts_table


def write_study_page(
    path: Path, title: str, report: Report, pages: Mapping[tuple[Path, int], tuple[str, bool]]
) -> None:
    """Write the page whole.

    Args:
        path: of the file.
        title: of the page.
        report: what is to be shown.
        pages: by folder of a run and instance, the address of the run's page as seen from this one, and whether it
            has a replay.

    Raises:
        StorageError: the file cannot be written.
    """
    known = any(one.evidence[0].count for one in report.findings)
    index = {
        "about": work(report.outcomes),
        "agree": agreement(report.outcomes, report.studies),
        "differs": [_table(one, "differs") for one in difference_tables(report.outcomes, report.studies)],
        "verdicts": _table(verdicts_table(report.findings), "verdicts") if known else None,
        "metrics": METRICS,
        "studies": [_study(one) for one in report.studies],
        "runs": [_run(one, pages) for one in by_fresh_mean(report.outcomes)],
    }
    files = resources.files("slcs2_jax.study") / "page_assets"
    main, programs = files / "study.html", [files / "study.js"]
    apart = " but the pages of the runs"
    write_text(path, document(title, "Runs compared", main, programs, index, Blocks(), apart=apart))


def by_fresh_mean(outcomes: tuple[Outcome, ...]) -> list[Outcome]:
    """By world, the highest mean over fresh deployments first; then those that have none yet, by their seed."""

    def place(one: Outcome) -> tuple[int, bool, float, str, int]:
        fresh = one.fresh_after(len(one.curve))
        world = CELLS.index(one.cell) if one.cell in CELLS else len(CELLS)
        return world, fresh is None, -(fresh or 0.0), one.arm, one.seed

    return sorted(outcomes, key=place)


def _study(study: Study) -> dict[str, Any]:
    tables = [
        {**_table(table, f"{study.name}_{name}"), "metric": next((m for m in METRICS if name.startswith(m)), None)}
        for name, table in study_tables(study).items()
        if table.rows
    ]
    return {
        "title": study.title,
        "state": [state_line(study), *(f"Missing: {line}" for line in study.missing)],
        "figures": figures(study),
        "tables": tables,
    }


def _table(table: Table, name: str) -> dict[str, Any]:
    return {"name": name, "title": table.title, "header": table.header, "rows": table.printed(), "csv": table.csv()}


def _run(one: Outcome, pages: Mapping[tuple[Path, int], tuple[str, bool]]) -> dict[str, Any]:
    address, replay = pages.get((one.folder, one.seed - one.settings.seed), (None, False))
    done = len(one.curve)
    return {
        "world": one.cell.title,
        "arm": arm_title(one.arm),
        "seed": one.seed,
        "fresh": one.fresh_after(done),
        "best": one.best(done) if one.evolves else None,
        "generations": done,
        "planned": one.planned,
        "ended": one.fresh is not None,
        "page": address,
        "replay": replay,
    }
