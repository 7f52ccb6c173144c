"""The claims as data, and verdicts on results that confirm, weaken or refute them."""

import pytest

from slcs2_jax.results.arm import CELLS, PLACES, cell_named
from slcs2_jax.study.claim import KINDS, Claim, Verdict, judge, load_claims, together
from slcs2_jax.study.collect import collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.study import BEST, FRESH, studies

HIGH, LOW = (0.5, 0.6, 0.7, 0.8), (0.1, 0.2, 0.3, 0.4)
MIXED = (0.15, 0.25, 0.35, 0.75)  # a higher mean than LOW's, no significance


def verdict(make, claim, metric=BEST):
    [finding] = judge([claim], studies(collect(make.root), reported_experiments()), metric)
    return finding


def runs(make, arm, cell, figures, fresh=None):
    for seed, best in enumerate(figures):
        make.evolved(arm, cell, seed, [best], fresh=fresh)


def claim(kind, **own):
    values = {"better": "slcs2", "worse": "ailta", "places": (cell_named("open_short"),), "experiment": "contributions"}
    return Claim(id="c", says="", kind=kind, **(values | own))


@pytest.mark.parametrize(
    ("better", "worse", "superior", "higher", "alike"),
    [
        (HIGH, LOW, Verdict.HOLDS, Verdict.HOLDS, Verdict.FAILS),
        (MIXED, LOW, Verdict.DIRECTION, Verdict.DIRECTION, Verdict.DIRECTION),
        (LOW, MIXED, Verdict.FAILS, Verdict.FAILS, Verdict.DIRECTION),
        (LOW, HIGH, Verdict.FAILS, Verdict.FAILS, Verdict.FAILS),
        (LOW, LOW, Verdict.FAILS, Verdict.FAILS, Verdict.HOLDS),
        ((0.11, 0.22, 0.31, 0.42), LOW, Verdict.DIRECTION, Verdict.DIRECTION, Verdict.HOLDS),
        (HIGH[:3], LOW[:3], Verdict.UNKNOWN, Verdict.UNKNOWN, Verdict.UNKNOWN),
    ],
)
def test_claims_about_two_arms(make, better, worse, superior, higher, alike):
    runs(make, "slcs2", "open_short", better)
    runs(make, "ailta", "open_short", worse)
    found = [verdict(make, claim(kind)).verdict for kind in ("superior", "higher", "alike")]
    assert found == [superior, higher, alike]


def test_the_better_arm_may_be_the_other(make):
    runs(make, "slcs2", "open_short", LOW)
    runs(make, "ailta", "open_short", HIGH)
    finding = verdict(make, claim("superior", better="ailta", worse="slcs2", paper={"open_short": 0.45}))
    [one] = finding.evidence
    assert (finding.verdict, one.value, one.a12, one.count) == (Verdict.HOLDS, pytest.approx(0.4), 1.0, 4)
    assert one.interval is not None
    assert one.interval.low <= one.value <= one.interval.high
    assert (one.paper, one.fits) == (0.45, False)
    assert one.p == pytest.approx(2 / 70)
    assert one.power is not None
    assert 0.9 < one.power < 1.0  # 0.45 is 3.5 standard deviations of these four


def test_the_papers_figure_in_our_interval(make):
    runs(make, "slcs2", "open_short", (0.5, 0.6, 0.7, 0.9))
    runs(make, "ailta", "open_short", (0.1, 0.3, 0.2, 0.4))
    found = {
        paper: verdict(make, claim("superior", paper={"open_short": paper})).evidence[0].fits for paper in (0.42, -0.42)
    }
    assert found == {0.42: True, -0.42: False}


def test_a_claim_about_several_worlds(make):
    places = tuple(map(cell_named, ("open_short", "jammed_short")))
    for arm, figures in (("slcs2", HIGH), ("ailta", LOW)):
        runs(make, arm, "open_short", figures)
    both = claim("superior", places=places)
    assert verdict(make, both).verdict is Verdict.UNKNOWN
    for arm, figures in (("slcs2", MIXED), ("ailta", LOW)):
        runs(make, arm, "jammed_short", figures)
    finding = verdict(make, both)
    assert finding.verdict is Verdict.DIRECTION
    assert [one.verdict for one in finding.evidence] == [Verdict.HOLDS, Verdict.DIRECTION]
    assert finding.evidence[0].p_holm == pytest.approx(4 / 70)


def test_one_refuted_world_refutes():
    assert together([Verdict.HOLDS, Verdict.UNKNOWN, Verdict.FAILS]) is Verdict.FAILS
    assert together([Verdict.HOLDS, Verdict.UNKNOWN, Verdict.DIRECTION]) is Verdict.UNKNOWN
    assert together([Verdict.HOLDS, Verdict.DIRECTION]) is Verdict.DIRECTION
    assert together([Verdict.HOLDS, Verdict.HOLDS]) is Verdict.HOLDS


@pytest.mark.parametrize(
    ("before", "after", "drop", "steady"),
    [
        (HIGH, LOW, Verdict.HOLDS, Verdict.FAILS),
        (MIXED, LOW, Verdict.DIRECTION, Verdict.DIRECTION),
        (LOW, HIGH, Verdict.FAILS, Verdict.FAILS),
        ((0.50, 0.52, 0.52, 0.54), (0.51, 0.52, 0.52, 0.53), Verdict.FAILS, Verdict.HOLDS),
    ],
)
def test_claims_about_one_arm_in_two_worlds(make, before, after, drop, steady):
    for arm in ("slcs2", "ailta"):
        runs(make, arm, "open_short", before)
        runs(make, arm, "jammed_short", after)
    about = {
        "better": "",
        "worse": "",
        "arm": "slcs2",
        "start": cell_named("open_short"),
        "places": (cell_named("jammed_short"),),
    }
    if drop is Verdict.FAILS and steady is Verdict.HOLDS:  # equal means are no drop
        assert verdict(make, claim("drop", **about)).evidence[0].value == pytest.approx(0.0)
    else:
        assert verdict(make, claim("drop", **about)).verdict is drop
    assert verdict(make, claim("steady", **about)).verdict is steady


@pytest.mark.parametrize(
    ("deployments", "rate", "expected"),
    [
        ([[-1.0, -1.0], [0.5, 0.5], [-1.0, -1.0], [0.5, 0.4]], 0.492, Verdict.HOLDS),
        ([[-1.0, -1.0], [0.5, 0.5], [0.3, 0.4], [0.5, 0.4]], 0.9, Verdict.FAILS),
        ([[-1.0, 0.5]] * 4, 0.492, Verdict.FAILS),  # something is delivered in each
        ([[0.5, 0.5]] * 4, 0.492, Verdict.FAILS),
        ([[0.5, 0.5]] * 4, 0.0, Verdict.HOLDS),
        ([[-1.0, -1.0]] * 4, 0.0, Verdict.FAILS),
    ],
)
def test_claims_about_failures(make, deployments, rate, expected):
    runs(make, "slcs2", "urban_short", HIGH)
    for seed, fitness in enumerate(deployments):
        make.designed("urban_short", seed, fitness)
    about = {"better": "", "worse": "", "arm": "designed", "places": (cell_named("urban_short"),), "rate": rate}
    finding = verdict(make, claim("failures", experiment="designed", **about))
    [one] = finding.evidence
    share = sum(max(own) == -1 for own in deployments) / 4
    assert (finding.verdict, one.value, one.paper) == (expected, pytest.approx(share), rate)


def test_a_search_fails_as_a_designed_behaviour_does(make):
    runs(make, "slcs2", "urban_short", (-1.0, 0.5, 0.6, 0.7))
    for seed in range(4):
        make.designed("urban_short", seed, [0.5])
    about = {"better": "", "worse": "", "arm": "slcs2", "places": (cell_named("urban_short"),), "rate": 0.0}
    [one] = verdict(make, claim("failures", experiment="designed", **about)).evidence
    assert one.value == 0.25


def test_by_fresh_means(make):
    runs(make, "slcs2", "open_short", HIGH, fresh=0.1)
    runs(make, "ailta", "open_short", LOW, fresh=0.2)
    assert verdict(make, claim("superior")).verdict is Verdict.HOLDS
    assert verdict(make, claim("superior"), FRESH).verdict is Verdict.FAILS


def test_without_the_arms_nothing_is_known(make):
    runs(make, "slcs2", "open_short", HIGH)
    for finding in judge(load_claims(), studies(collect(make.root), reported_experiments()), BEST):
        assert finding.verdict is Verdict.UNKNOWN


def test_the_claims_of_the_paper_are_well_formed():
    claims = load_claims()
    experiments = reported_experiments()
    assert len({one.id for one in claims}) == len(claims) >= 20
    for one in claims:
        arms = experiments[one.experiment][1]
        assert one.kind in KINDS
        assert one.arms
        assert set(one.arms) <= set(arms)
        assert one.places
        assert set(one.places) <= set(PLACES)
        assert set(one.paper or {}) <= {place.name for place in one.places}
        if one.better:
            assert arms[0] in (one.better, one.worse)  # every comparison is with the reference
        assert (one.rate is not None) == (one.kind == "failures")
        assert (one.start is not None) == (one.kind in ("drop", "steady"))
    assert {one.experiment for one in claims} == set(experiments)
    assert next(one for one in claims if one.id == "novelty").places == CELLS
