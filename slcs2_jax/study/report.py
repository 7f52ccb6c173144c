"""The report on a folder of runs: tables, figures, and the verdict on each of the paper's claims."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slcs2_jax.config import InputError, escape
from slcs2_jax.config.field import show
from slcs2_jax.results.files import make_folder, write_text
from slcs2_jax.results.progress import duration
from slcs2_jax.study.claim import KINDS, Finding, Verdict, judge, load_claims
from slcs2_jax.study.collect import Outcome, collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.statistics import Interval
from slcs2_jax.study.study import BEST, FRESH, METRICS, Study, studies
from slcs2_jax.study.table import Table, comparisons_table, descriptions_table, runs_table

REPORT = "report"  # folder below the runs', unless another is named

_FIGURES = ("_best", "_fresh", "_curves")
_NOTES = """\
*n*: instances that every arm of the table has. *CI90*: Student's t interval of the mean; *BCa 90*: bootstrap \
interval. *> -1*: share of instances that deliver anything; *> 0*: share that deliver a greater share of the packets \
than they use of the time. *fresh*: the winner's mean over fresh deployments, which has not been chosen for being \
high, as the best fitness has. A designed behaviour's result is the mean of its deployments in an instance, by either \
metric. *A12*: chance that the first arm's result is the better one. *Holm p*: Mann-Whitney's, corrected over all \
cells of the experiment (overall figures: over those). *Superior*: higher mean; significantly, if the CI90s do not \
overlap and Mann-Whitney's p < 0.1.
"""


@dataclass(frozen=True)
class Report:
    """What was written, and what it comes to."""

    folder: Path
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
        folder: of an experiment, or any with runs in it.
        out: where to; by default `report` in the folder.
        generations: compare after so many; by default the most that all runs of an experiment share.
        passed: gets a line for each folder that was passed over, and why.

    Raises:
        InputError: no runs, runs that cannot be compared, or a place that cannot be written to.
    """
    outcomes = collect(folder, passed)
    found = studies(outcomes, reported_experiments(), generations)
    findings = judge(load_claims(), found, BEST) + judge(load_claims(), found, FRESH)
    place = Path(folder) / REPORT if out is None else Path(out)
    try:
        if out is None:
            make_folder(place, inside=Path(folder))
        place.mkdir(parents=True, exist_ok=True)
        for path in place.iterdir():  # an older report may have had figures that this one has not
            if path.suffix in (".png", ".svg") and path.stem.endswith(_FIGURES):
                path.unlink()
        write_text(place / "runs.csv", runs_table(outcomes, Path(folder)).csv())
        _write_tables(place, found)
        _write_verdicts(place, findings)
        drawn = _write_figures(place, found)
        write_text(place / "report.md", _markdown(outcomes, found, findings, drawn))
    except OSError as error:
        raise InputError(f"out={show(str(place))}: cannot be written ({error.strerror})") from None
    return Report(place, tuple(found), tuple(findings))


def _write_tables(place: Path, found: Sequence[Study]) -> None:
    latex = []
    for study in found:
        write_text(place / f"{study.name}_fitness.csv", descriptions_table(study).csv())
        for metric in METRICS:
            write_text(place / f"{study.name}_{metric}_comparisons.csv", comparisons_table(study, metric).csv())
        latex += [table.latex() for table in _tables(study)]
    write_text(place / "tables.tex", "\n".join(latex))


def _tables(study: Study) -> list[Table]:
    tables = [descriptions_table(study), *(comparisons_table(study, metric) for metric in METRICS)]
    return [table for table in tables if table.rows]


def _write_figures(place: Path, found: Sequence[Study]) -> dict[str, list[Path]]:
    """The figures of each study; none without matplotlib."""
    try:
        from slcs2_jax.looking import drawing
        from slcs2_jax.study import figure
    except ImportError:
        return {}
    drawn: dict[str, list[Path]] = {}
    for study in found:
        pictures = drawn.setdefault(study.name, [])
        for metric in METRICS:
            if study.descriptions(metric):
                pictures += drawing.save(
                    lambda study=study, metric=metric: figure.fitness_figure(study, metric),  # type: ignore[misc]
                    place / f"{study.name}_{metric}",
                )
        if study.generations and study.descriptions(BEST):
            pictures += drawing.save(
                lambda study=study: figure.curves_figure(study),  # type: ignore[misc]
                place / f"{study.name}_curves",
            )
    return drawn


def _write_verdicts(place: Path, findings: Sequence[Finding]) -> None:
    plain = [_plain(one) for one in findings]
    write_text(place / "verdicts.json", json.dumps(plain, indent=2, allow_nan=False) + "\n")
    write_text(place / "verdicts.md", "# The paper's claims and our verdicts\n\n" + verdicts_markdown(findings))


def _plain(finding: Finding) -> dict[str, Any]:
    claim = finding.claim
    return {
        "id": claim.id,
        "experiment": claim.experiment,
        "says": claim.says,
        "kind": claim.kind,
        "rule": KINDS[claim.kind],
        "metric": finding.metric,
        "verdict": finding.verdict,
        "evidence": [asdict(one) for one in finding.evidence],
    }


def verdicts_markdown(findings: Sequence[Finding]) -> str:
    """Each claim with its verdict by both metrics and the evidence by the paper's; then what verdicts mean."""
    by_id: dict[str, dict[str, Finding]] = {}
    for one in findings:
        by_id.setdefault(one.claim.id, {})[one.metric] = one
    rows = []
    for pair in by_id.values():
        best = pair[BEST]
        rows.append((best.claim.experiment, best.claim.says, best.verdict, pair[FRESH].verdict, evidence_text(best)))
    header = ("experiment", "the paper says", "verdict", "by fresh means", "how sure (by best fitness)")
    table = Table("Verdicts", header, tuple(rows)).markdown()
    counts = Counter(pair[BEST].verdict for pair in by_id.values())
    told = ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)
    kinds = "\n".join(f"- *{kind}*: {rule}" for kind, rule in KINDS.items())
    return f"{told}.\n\n{table}\nWhat a claim of each kind needs, in every world it speaks of:\n\n{kinds}\n"


def evidence_text(finding: Finding) -> str:
    """The evidence in words: of several places how many confirm it, and the least sure of them."""
    known = [one for one in finding.evidence if one.value is not None]
    if not known:
        return "no results"
    order = [Verdict.FAILS, Verdict.UNKNOWN, Verdict.DIRECTION, Verdict.HOLDS]
    weakest = min(known, key=lambda one: (order.index(one.verdict), -(one.p if one.p is not None else 0.0)))
    parts = []
    if len(finding.evidence) > 1:
        holding = sum(one.verdict is Verdict.HOLDS for one in known)
        agreeing = sum(one.verdict in (Verdict.HOLDS, Verdict.DIRECTION) for one in known)
        parts.append(
            f"{holding} of {len(finding.evidence)} hold, {agreeing} at least in direction; the weakest, {weakest.place}"
        )
    text = f"n = {weakest.count}: {weakest.value:+.3f}{_between(weakest.interval)}"
    if weakest.p is not None:
        holm = "" if weakest.p_holm is None else f" (Holm {weakest.p_holm:.3f})"
        text += f", p {weakest.p:.3f}{holm}, A12 {weakest.a12:.2f}{_between(weakest.a12_interval)}"
    parts.append(text)
    printed = [one for one in known if one.paper is not None]
    parts += [
        f"the paper's {one.paper:+.3f} for {one.place} lies {'in' if one.fits else 'outside'} our interval"
        f"{'' if one is weakest else _between(one.interval)}"
        for one in printed
    ]
    return "; ".join(parts)


def _between(interval: Interval | None) -> str:
    return "" if interval is None else f" [{interval.low:+.3f}, {interval.high:+.3f}]"


def _markdown(
    outcomes: Sequence[Outcome], found: Sequence[Study], findings: Sequence[Finding], drawn: dict[str, list[Path]]
) -> str:
    parts = ["# Report", _provenance(outcomes)]
    for study in found:
        parts += [f"## {escape.markdown(study.title)}", _state(study)]
        parts += [f"![{path.stem}]({path.name})" for path in drawn.get(study.name, []) if path.suffix == ".png"]
        parts += [table.markdown() for table in _tables(study)]
    parts += [_NOTES, "## The paper's claims", verdicts_markdown(findings)]
    if not drawn:
        parts.append("No figures: they need matplotlib, the extra `plot`.")
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _state(study: Study) -> str:
    """At how many generations arms are compared, and what is missing."""
    most = max((len(one.curve) for one in study.outcomes), default=0)
    lines = []
    if study.generations:
        rest = f"; the longest has {most}" if most > study.generations else ""
        lines.append(f"Compared after {study.generations} generations of every run{rest}.")
    if study.missing:
        lines += ["", "Missing:", "", *(f"- {escape.markdown(line)}" for line in study.missing)]
    else:
        lines.append("Nothing is missing.")
    return "\n".join(lines)


def _provenance(outcomes: Sequence[Outcome]) -> str:
    """What made the runs: their number, work, devices, versions and commands."""
    steps, seconds = sum(one.env_steps for one in outcomes), sum(one.seconds for one in outcomes)
    lines = [
        f"{len(outcomes)} runs, {sum(one.evaluations for one in outcomes):,} episodes and {steps:,} env-steps of search"
        + (f"; {duration(seconds)} of computing" if seconds else "")
        + "."
    ]
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
