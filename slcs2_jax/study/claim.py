"""The paper's claims as data, and the verdict of our runs on each: does it hold, and how sure is that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax.results.arm import CELLS, Cell, cell_named
from slcs2_jax.study.statistics import ALPHA, Comparison, Interval, contrast, power, share_interval
from slcs2_jax.study.study import Contest, Study

ALIKE = 0.1  # fitness; means that differ by less, 5 % of the fitness range, count as alike


class Verdict(StrEnum):
    """What our runs say of a claim."""

    HOLDS = "holds"
    DIRECTION = "holds in direction"
    FAILS = "does not hold"
    UNKNOWN = "not enough data"


# What each kind of claim needs to hold, to hold in direction; anything else refutes it.
KINDS = {
    "superior": "holds: significantly superior by the paper's rule (higher mean, CI90s apart, Mann-Whitney p < 0.1); "
    "in direction: higher mean",
    "higher": "holds: higher mean and Mann-Whitney p < 0.1; in direction: higher mean",
    "alike": "holds: the 90 % interval of the difference lies within ±5 % of the fitness range; in direction: no "
    "significant difference by the paper's rule",
    "drop": "holds: the 90 % interval of the drop lies above 0; in direction: lower mean",
    "steady": "holds: the 90 % interval of the difference lies within ±5 % of the fitness range; in direction: the "
    "interval holds 0",
    "failures": "holds: the 90 % interval of the share of instances in which nothing is delivered, in any deployment "
    "that the figure is the mean of, holds the paper's; in direction: at least half of the paper's "
    "share, or at most 5 % where the paper has none",
}
FEWEST = 4  # instances; of fewer nothing can be significant by the paper's rule, so nothing could be confirmed


@dataclass(frozen=True)
class Claim:
    """One claim; the fields are explained in claims.yaml. Those that its kind does not use are empty."""

    id: str
    experiment: str
    says: str
    kind: str
    better: str = ""
    worse: str = ""
    arm: str = ""
    start: Cell | None = None
    places: tuple[Cell, ...] = ()
    paper: Mapping[str, float] | None = None
    rate: float | None = None

    @property
    def arms(self) -> tuple[str, ...]:
        """The arms it speaks of."""
        return tuple(arm for arm in (self.better, self.worse, self.arm) if arm)


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What was found in one place.

    Attributes:
        value: our difference in fitness, or share of failures; interval: its 90 % interval.
        paper: the paper's figure, if it prints one; fits: does our interval hold it?
        p, p_holm, p_wilcoxon, a12, a12_interval: see `Comparison`; None for kinds without a comparison of arms.
        power: chance that so many instances show the paper's figure, were it true; None where it prints none.
    """

    place: str
    verdict: Verdict
    count: int
    value: float | None = None
    interval: Interval | None = None
    paper: float | None = None
    fits: bool | None = None
    p: float | None = None
    p_holm: float | None = None
    p_wilcoxon: float | None = None
    a12: float | None = None
    a12_interval: Interval | None = None
    power: float | None = None


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A claim's verdict, by one metric, with the evidence of every place."""

    claim: Claim
    metric: str
    verdict: Verdict
    evidence: tuple[Evidence, ...]


def load_claims() -> list[Claim]:
    """The claims of claims.yaml."""
    from omegaconf import OmegaConf

    plain: Any = OmegaConf.to_container(OmegaConf.load(Path(__file__).with_name("claims.yaml")))
    return [_claim(dict(one)) for one in plain]


def judge(claims: Sequence[Claim], studies: Sequence[Study], metric: str) -> list[Finding]:
    """The verdict on every claim by one metric."""
    by_name = {study.name: study for study in studies}
    return [_judge(claim, by_name.get(claim.experiment), metric) for claim in claims]


def _claim(values: dict[str, Any]) -> Claim:
    cells = values.pop("cells", None)
    to, start = values.pop("to", None), values.pop("from", None)
    places = CELLS if cells == "all" else tuple(cell_named(name) for name in cells or [to])
    return Claim(places=places, start=cell_named(start) if start else None, **values)


def _judge(claim: Claim, study: Study | None, metric: str) -> Finding:
    if study is None or not set(claim.arms) <= set(study.arms):
        evidence = tuple(Evidence(place=place.name, verdict=Verdict.UNKNOWN, count=0) for place in claim.places)
    elif claim.kind == "failures":  # one share over all the places together
        evidence = (_failures(claim, study, metric),)
    else:
        weigh = _weigh_cells if claim.kind in ("drop", "steady") else _weigh_arms
        evidence = tuple(_with_paper(claim, weigh(claim, study, place, metric)) for place in claim.places)
    return Finding(claim=claim, metric=metric, verdict=together([one.verdict for one in evidence]), evidence=evidence)


def together(verdicts: Sequence[Verdict]) -> Verdict:
    """The verdict on a claim about several places: one refuted place refutes it, and each must confirm it."""
    for decisive in (Verdict.FAILS, Verdict.UNKNOWN, Verdict.DIRECTION):
        if decisive in verdicts:
            return decisive
    return Verdict.HOLDS


def _with_paper(claim: Claim, evidence: Evidence) -> Evidence:
    paper = (claim.paper or {}).get(evidence.place)
    if paper is None:
        return evidence
    fits = evidence.interval.holds(paper) if evidence.interval else None
    return replace(evidence, paper=paper, fits=fits)


def _weigh_arms(claim: Claim, study: Study, place: Cell, metric: str) -> Evidence:
    """Kinds that compare two arms in one place."""
    other = claim.worse if claim.better == study.reference else claim.better
    found = study.comparisons(metric).get(Contest(other, place))
    if found is None or found.count < FEWEST:
        return Evidence(place=place.name, verdict=Verdict.UNKNOWN, count=found.count if found else 0)
    if other == claim.better:
        found = _turned(found)
    interval = found.bootstrap or Interval(found.difference, found.difference)  # every instance differs alike
    printed = (claim.paper or {}).get(place.name)
    return Evidence(
        place=place.name,
        verdict=_verdict_on_arms(claim.kind, found, interval),
        count=found.count,
        value=found.difference,
        interval=interval,
        p=found.p_mann_whitney,
        p_holm=found.p_holm,
        p_wilcoxon=found.p_wilcoxon,
        a12=found.a12,
        a12_interval=found.a12_interval,
        power=None if printed is None else power(printed, found),
    )


def _verdict_on_arms(kind: str, found: Comparison, interval: Interval) -> Verdict:
    if kind == "alike":
        if interval.low >= -ALIKE and interval.high <= ALIKE:
            return Verdict.HOLDS
        return Verdict.FAILS if found.significant else Verdict.DIRECTION
    if found.difference <= 0:
        return Verdict.FAILS
    assert found.p_mann_whitney is not None
    sure = found.significant if kind == "superior" else found.p_mann_whitney < ALPHA
    return Verdict.HOLDS if sure else Verdict.DIRECTION


def _turned(one: Comparison) -> Comparison:
    """The comparison of y with x."""

    def mirrored(interval: Interval | None, about: float) -> Interval | None:
        return None if interval is None else Interval(about - interval.high, about - interval.low)

    return replace(
        one,
        difference=-one.difference,
        bootstrap=mirrored(one.bootstrap, 0.0),
        a12=1 - one.a12,
        a12_interval=mirrored(one.a12_interval, 1.0),
    )


def _weigh_cells(claim: Claim, study: Study, place: Cell, metric: str) -> Evidence:
    """Kinds that compare one arm in two cells."""
    assert claim.start is not None
    before, after = study.sample(claim.arm, claim.start, metric), study.sample(claim.arm, place, metric)
    count = min(len(before), len(after))
    if count < FEWEST:
        return Evidence(place=place.name, verdict=Verdict.UNKNOWN, count=count)
    drop, found = contrast(before, after)
    interval = found or Interval(drop, drop)
    if claim.kind == "drop":
        verdict = Verdict.HOLDS if interval.low > 0 else Verdict.DIRECTION if drop > 0 else Verdict.FAILS
    else:
        near = interval.low >= -ALIKE and interval.high <= ALIKE
        verdict = Verdict.HOLDS if near else Verdict.DIRECTION if interval.holds(0.0) else Verdict.FAILS
    return Evidence(place=place.name, verdict=verdict, count=count, value=drop, interval=interval)


def _failures(claim: Claim, study: Study, metric: str) -> Evidence:
    """Share of instances in which nothing is delivered, over all the places together; the same for every arm."""
    assert claim.rate is not None
    failed = np.concatenate([study.sample(claim.arm, place, metric) for place in claim.places]) <= -1
    where = "+".join(place.name for place in claim.places)
    complete = all(len(study.seeds(place, metric)) >= FEWEST for place in claim.places)
    if not complete:
        return Evidence(place=where, verdict=Verdict.UNKNOWN, count=len(failed), paper=claim.rate)
    share, interval = float(failed.mean()), share_interval(int(failed.sum()), len(failed))
    near = share >= claim.rate / 2 if claim.rate else share <= 0.05
    fits = interval.holds(claim.rate)
    return Evidence(
        place=where,
        verdict=Verdict.HOLDS if fits else Verdict.DIRECTION if near else Verdict.FAILS,
        count=len(failed),
        value=share,
        interval=interval,
        paper=claim.rate,
        fits=fits,
    )
