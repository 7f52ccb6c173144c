"""The report on a folder of runs: tables, figures, and the verdict on each of the paper's claims."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from slcs2_jax.config import InputError
from slcs2_jax.config.field import show
from slcs2_jax.results.files import make_folder, write_text
from slcs2_jax.study.claim import Finding, judge, load_claims
from slcs2_jax.study.collect import Outcome, collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.overall import overall_table
from slcs2_jax.study.report_text import report_text, study_text
from slcs2_jax.study.response import grids, responses
from slcs2_jax.study.response_table import grid_table, grids_table, interactions_table, responses_table
from slcs2_jax.study.robustness import robustness_table
from slcs2_jax.study.study import BEST, FRESH, GENERATION, METRICS, MOST_ARMS, SPENT, Study, studies
from slcs2_jax.study.table import Table, comparisons_table, descriptions_table, failures_table, runs_table
from slcs2_jax.study.verdict_text import plain, verdicts_markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "_report"  # ends the name of a study's page
REPORT = "report"  # folder below the runs', unless another is named

# Files of an earlier report, by the ends of their names: that one may have had some that this one has not.
_TABLES = ("_fitness", "_failures", "_comparisons", "_overall", "_responses", "_means", "_interactions", "_robustness")
_FIGURES = ("_best", "_fresh", "_curves", "_curves_by_episodes", "_curves_by_env_steps")
_OF_REPORTS = {".png": _FIGURES, ".svg": _FIGURES, ".csv": _TABLES, ".md": (PAGE,)}


@dataclass(frozen=True)
class Report:
    """What was written, and what it comes to."""

    folder: Path
    outcomes: tuple[Outcome, ...]
    studies: tuple[Study, ...]
    findings: tuple[Finding, ...]


def write_report(
    folder: str | Path,
    out: str | Path | None = None,
    generations: int | None = None,
    passed: list[str] | None = None,
) -> Report:
    """Write the report on all runs in a folder and below it; an older report there is replaced.

    Args:
        folder: of an experiment or a sweep, or any with runs in it.
        out: where to; by default `report` in the folder.
        generations: compare after so many; by default the most that all runs of an experiment share.
        passed: gets a line for each folder that was passed over, and why.

    Raises:
        InputError: no runs, or a place that cannot be written to.
    """
    outcomes = collect(folder, passed)
    episodes = sorted({most for one in outcomes if (most := one.settings.search.episodes) is not None})
    found = studies(outcomes, reported_experiments(episodes), generations)
    findings = judge(load_claims(), found, BEST) + judge(load_claims(), found, FRESH)
    place = Path(folder) / REPORT if out is None else Path(out)
    try:
        if out is None:
            make_folder(place, inside=Path(folder))
        place.mkdir(parents=True, exist_ok=True)
        for path in place.iterdir():
            if path.stem.endswith(_OF_REPORTS.get(path.suffix, ())):
                path.unlink()
        write_text(place / "runs.csv", runs_table(outcomes, Path(folder)).csv())
        write_text(place / "report.md", report_text(outcomes, {one: f"{one.name}{PAGE}.md" for one in found}, findings))
        tables = {study: _write_tables(place, study) for study in found}
        latex = [table.latex() for printed in tables.values() for table in printed]
        write_text(place / "tables.tex", "\n".join(latex))
        _write_verdicts(place, findings)
        drawn = _write_figures(place, found)
        for study, printed in tables.items():
            text = study_text(study, printed, findings, drawn.get(study.name, []))
            write_text(place / f"{study.name}{PAGE}.md", text)
    except OSError as error:
        raise InputError(f"out={show(str(place))}: cannot be written ({error.strerror})") from None
    return Report(place, tuple(outcomes), tuple(found), tuple(findings))


def study_tables(study: Study) -> dict[str, Table]:
    """All tables of a study by name."""
    named = {"fitness": descriptions_table(study), "failures": failures_table(study)}
    named |= {f"{metric}_comparisons": comparisons_table(study, metric) for metric in METRICS}
    if study.to_end:
        named |= {f"{metric}_overall": overall_table(study, metric) for metric in METRICS}
    if study.factors:
        named |= {f"{metric}_responses": responses_table(study, metric) for metric in METRICS}
        named |= {f"{metric}_means": grids_table(study, metric) for metric in METRICS}
        named |= {f"{metric}_interactions": interactions_table(study, metric) for metric in METRICS}
        named |= {f"{metric}_robustness": robustness_table(study, metric) for metric in METRICS}
    return named


def _write_tables(place: Path, study: Study) -> list[Table]:
    """Each table as CSV; returns those that are printed."""
    named = study_tables(study)
    for name, table in named.items():
        if table.rows or name.endswith(("fitness", "_comparisons")):
            write_text(place / f"{study.name}_{name}.csv", table.csv())
    if study.factors:  # what every arm comes to would be a row for each combination: in CSV alone
        means = [grid_table(grid) for metric in METRICS for grid in grids(study, metric)]
        robust, responding, together = (
            [table for name, table in named.items() if name.endswith(end)]
            for end in ("_robustness", "_responses", "_interactions")
        )
        return [table for table in (*robust, *responding, *means, *together) if table.rows]
    return [table for table in named.values() if table.rows]


def _write_figures(place: Path, found: Sequence[Study]) -> dict[str, list[Path]]:
    """The figures of each study; none without matplotlib."""
    try:
        from slcs2_jax.looking import drawing
    except ImportError:
        return {}
    drawn: dict[str, list[Path]] = {}
    for study in found:
        pictures = drawn.setdefault(study.name, [])
        for name, draw in _figures(study):
            pictures += drawing.save(draw, place / f"{study.name}_{name}")
    return drawn


def _figures(study: Study) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Names and how each is drawn."""
    from slcs2_jax.study import figure, response_figure

    few = len(study.arms) <= MOST_ARMS
    for metric in METRICS:
        if study.descriptions(metric) and few:
            yield metric, partial(figure.fitness_figure, study, metric)
        for number, factor in enumerate(study.factors):
            own = [one for one in responses(study, metric) if one.factor is factor]
            if own:
                yield f"{_plain(factor.name)}_{metric}", partial(response_figure.responses_figure, own)
            for other in study.factors[number + 1 :]:
                both = [one for one in grids(study, metric) if (one.rows, one.columns) == (factor, other)]
                if both:
                    name = f"{_plain(factor.name)}_and_{_plain(other.name)}_{metric}"
                    yield name, partial(response_figure.grids_figure, both)
    if study.generations and study.descriptions(BEST) and few:
        for by in SPENT:
            yield "curves" if by == GENERATION else f"curves_by_{_plain(by)}", partial(figure.curves_figure, study, by)


def _plain(setting: str) -> str:
    return setting.replace(".", "_").replace("-", "_")


def _write_verdicts(place: Path, findings: Sequence[Finding]) -> None:
    told = [plain(one) for one in findings]
    write_text(place / "verdicts.json", json.dumps(told, indent=2, allow_nan=False) + "\n")
    write_text(place / "verdicts.md", "# The paper's claims and our verdicts\n\n" + verdicts_markdown(findings))
