"""Verdicts on the paper's claims, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from slcs2_jax.study.claim import KINDS, Evidence, Finding, Verdict
from slcs2_jax.study.statistics import Interval
from slcs2_jax.study.study import BEST, FRESH
from slcs2_jax.study.table import Table


def plain(finding: Finding) -> dict[str, Any]:
    """As JSON has it."""
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


def verdicts_table(findings: Sequence[Finding]) -> Table:
    """Each claim with its verdict by both metrics and the evidence of both: fresh means decide."""
    rows = []
    for pair in _by_claim(findings).values():
        best = pair[BEST]
        fresh, own = (f"{evidence_text(pair[metric])}" for metric in (FRESH, BEST))
        rows.append((best.claim.experiment, best.claim.says, pair[FRESH].verdict, fresh, best.verdict, own))
    header = (
        "experiment", "the paper says", "by fresh means", "how sure (fresh)", "by best fitness", "how sure (best)",
    )  # fmt: skip
    return Table("Verdicts", header, tuple(rows))


def _by_claim(findings: Sequence[Finding]) -> dict[str, dict[str, Finding]]:
    found: dict[str, dict[str, Finding]] = {}
    for one in findings:
        found.setdefault(one.claim.id, {})[one.metric] = one
    return found


def verdicts_markdown(findings: Sequence[Finding]) -> str:
    """Each claim with its verdict and evidence by both metrics; then what verdicts mean."""
    table = verdicts_table(findings).markdown()
    kinds = "\n".join(f"- *{kind}*: {rule}" for kind, rule in KINDS.items())
    needs = "What a claim of each kind needs, in every world it speaks of:"
    return f"{counts_text(findings)}\n\n{table}\n{needs}\n\n{kinds}\n"


def counts_text(findings: Sequence[Finding]) -> str:
    """How many claims have which verdict, by both metrics."""
    told = {metric: _counts([one for one in findings if one.metric == metric]) for metric in (FRESH, BEST)}
    return (
        f"By fresh means, which decide: {told[FRESH]}. By the search's own best, the paper's figure, which is chosen "
        f"for being high: {told[BEST]}."
    )


def _counts(findings: Sequence[Finding]) -> str:
    counts = Counter(one.verdict for one in findings)
    return ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)


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
        f"{_seen(one)}the paper's {one.paper:+.3f} for {one.place} lies {'in' if one.fits else 'outside'} our interval"
        f"{'' if one is weakest else _between(one.interval)}"
        for one in printed
    ]
    return "; ".join(parts)


def _seen(one: Evidence) -> str:
    """How likely so few instances were to show what the paper reports."""
    return "" if one.power is None else f"power {one.power:.2f} for what is printed; "


def _between(interval: Interval | None) -> str:
    return "" if interval is None else f" [{interval.low:+.3f}, {interval.high:+.3f}]"
