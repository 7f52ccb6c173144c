"""report.md: what made the runs and in what they differ; and a page for each study: tables, figures, verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config import escape
from slcs2_jax.results.arm import CELLS, arm_title, ordered
from slcs2_jax.results.progress import duration
from slcs2_jax.study.claim import Finding
from slcs2_jax.study.collect import Outcome
from slcs2_jax.study.response_table import differences_table, shared_table
from slcs2_jax.study.study import Study
from slcs2_jax.study.table import Table
from slcs2_jax.study.verdict_text import counts_text, verdicts_markdown

_NOTES = """\
## What the words mean

Every figure is by one of two measures. *Best*: the greatest fitness of a search, the paper's figure, which has been \
chosen for being high. *Fresh*: the winner's mean over fresh deployments, which has not. A designed behaviour's result \
is the mean of its deployments in an instance, by either.

*n*: instances that every arm of the table has; overall, where worlds share seeds and so start positions and \
buildings, the seeds: one figure for each, the mean of its worlds (failures are counted in every world). *CI90*: \
Student's t interval of the mean; *BCa 90*: bootstrap interval. *> 0*: share of instances that deliver a greater \
share of the packets than they use of the time. *A12*: chance that the first arm's result, or that of the value named, \
is the better one. *Visible*: the least true difference that so many instances show four times out of five \
(Mann-Whitney, p < 0.1, samples as spread as these). *Holm p*: Mann-Whitney's, corrected over all cells of the \
experiment (overall figures: over those), or over all effects of a table of responses. *Superior*: higher mean; \
significantly, if the CI90s do not overlap and Mann-Whitney's p < 0.1. A *failure* is an instance in which no \
deployment delivers anything, of a search as of a designed behaviour.
"""
_SWEEP_NOTES = """\
A *response* changes one setting and leaves the others at the values named under *compared with*; differences are \
taken instance by instance from the runs with these values. An *interaction* is what two changes do together beyond \
the sum of what each does alone; 0 if they add up. Algorithms are compared *under each setting* that both of them were \
run with: *same*, if the one that is better with the settings as they are is better there, too. These p are not \
corrected: the table asks whether a verdict depends on a setting, and is no verdict itself.
"""


def report_text(outcomes: Sequence[Outcome], pages: Mapping[Study, str], findings: Sequence[Finding]) -> str:
    """What made the runs, in what they differ, what the paper's claims come to, and where each study's page is.

    Args:
        outcomes: all results.
        pages: the studies, and the name of each one's page beside this one.
        findings: the verdicts by both metrics.
    """
    parts = ["# Report", _provenance(outcomes)]
    for study, page in pages.items():
        parts += [f"## {escape.markdown(study.title)}", _state(study), f"[Figures, tables, verdicts]({page})"]
    if _judged(findings):
        parts += ["## The paper's claims", counts_text(findings), "[Every claim with its verdict](verdicts.md)"]
    parts += ["## What differs", escape.markdown(agreement(outcomes, list(pages)))]
    parts += [table.markdown() for table in difference_tables(outcomes, list(pages))]
    return _joined([*parts, _NOTES])


def study_text(study: Study, tables: Sequence[Table], findings: Sequence[Finding], drawn: Sequence[Path]) -> str:
    """A study's page: its state, figures, tables, and the verdicts on the claims that are of it.

    Args:
        study: what was found.
        tables: those to print.
        findings: the verdicts by both metrics, on claims of any study.
        drawn: figures that were written beside the page.
    """
    parts = [f"# {escape.markdown(study.title)}", _state(study)]
    parts += [f"![{path.stem}]({path.name})" for path in drawn if path.suffix == ".png"]
    if not drawn:
        parts.append("No figures: they need matplotlib, the extra `plot`.")
    parts += [table.markdown() for table in tables]
    parts += [_SWEEP_NOTES] if study.factors else []
    own = [one for one in findings if one.claim.experiment == study.name]
    if _judged(own):
        parts += ["## The paper's claims", verdicts_markdown(own)]
    return _joined([*parts, _NOTES])


def _judged(findings: Sequence[Finding]) -> bool:
    return any(one.evidence[0].count for one in findings)


def _joined(parts: Sequence[str]) -> str:
    return "\n\n".join(part.strip() for part in parts) + "\n"


def agreement(outcomes: Sequence[Outcome], found: Sequence[Study]) -> str:
    """Algorithms and worlds, and whether there is more in which the runs differ."""
    algorithms = ", ".join(arm_title(name) for name in ordered(one.algorithm for one in outcomes))
    worlds = ", ".join(cell.title for cell in CELLS if any(one.cell == cell for one in outcomes))
    rest = "" if any(study.factors for study in found) else " In all other settings the runs agree."
    return f"Algorithms: {algorithms}. Worlds: {worlds}.{rest}"


def difference_tables(outcomes: Sequence[Outcome], found: Sequence[Study]) -> list[Table]:
    """In which settings the runs differ, and what they share that is not at its default; without empty ones."""
    factors = next((study.factors for study in found if study.factors), ())
    tables = differences_table(outcomes, factors), shared_table(outcomes)
    return [table for table in tables if table.rows]


def state_line(study: Study) -> str:
    """At how many generations arms are compared, and whether anything is missing."""
    most = max((len(one.curve) for one in study.outcomes), default=0)
    told = [] if study.missing else ["Nothing is missing."]
    if study.to_end:
        told.insert(0, "Compared where each search ended, by its episodes.")
    elif study.generations:
        rest = f"; the longest has {most}" if most > study.generations else ""
        told.insert(0, f"Compared after {study.generations} generations of every run{rest}.")
    return " ".join(told)


def _state(study: Study) -> str:
    missing = ["", "Missing:", "", *(f"- {escape.markdown(line)}" for line in study.missing)] if study.missing else []
    return "\n".join([state_line(study), *missing])


def work(outcomes: Sequence[Outcome]) -> str:
    """How many runs, and what they cost."""
    steps, seconds = sum(one.env_steps for one in outcomes), sum(one.seconds for one in outcomes)
    return (
        f"{len(outcomes)} runs, {sum(one.evaluations for one in outcomes):,} episodes and {steps:,} env-steps of search"
        + (f"; {duration(seconds)} of computing" if seconds else "")
        + "."
    )


def _provenance(outcomes: Sequence[Outcome]) -> str:
    """What made the runs: their number, work, devices, versions and commands."""
    lines = [work(outcomes)]
    devices = sorted({str(one.record.get("device", "unknown")) for one in outcomes})
    versions = sorted({_versions(one.record) for one in outcomes})
    commands = sorted({_command(one.record) for one in outcomes})
    made = f"Devices: {', '.join(devices)}. Versions: {'; '.join(versions)}."
    lines += [escape.markdown(made), "", "Commands:", ""]
    return "\n".join([*lines, *(f"- {escape.markdown_code(command)}" for command in commands)])


def _command(record: Any) -> str:
    """As it was typed; what was added for Hydra names a scratch folder, another one every time."""
    words = str(record.get("command", "unknown")).split()
    return " ".join(word for word in words if not word.startswith("hydra.sweep."))


def _versions(record: Any) -> str:
    found = record.get("versions", {})
    return ", ".join(f"{name} {version}" for name, version in sorted(found.items())) or "unknown"
