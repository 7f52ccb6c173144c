"""Comparisons of algorithms under other settings, by hand; and the report that prints them."""

import csv

import pytest

from slcs2_jax.results.arm import cell_named
from slcs2_jax.study.collect import collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.report import write_report
from slcs2_jax.study.robustness import repeated, robustness_table
from slcs2_jax.study.study import FRESH, studies

# mean of full and of no exchange, by speed and clearance
LEVEL = {(2.0, 2.0): (0.5, 0.3), (4.0, 2.0): (0.6, 0.5), (2.0, 4.0): (0.2, 0.4), (4.0, 4.0): (0.7, None)}


@pytest.fixture
def sweep(make):
    for (speed, clearance), levels in LEVEL.items():
        other = type(make)(make.root / f"{speed}_{clearance}")
        for arm, level in zip(("slcs2", "no_exchange"), levels, strict=True):
            for seed in range(4 if level is not None else 0):
                own = {"swarm": {"speed": speed, "clearance": clearance}}
                other.evolved(arm, "open_short", seed, [0.9], fresh=level + seed / 100, **own)
    return make.root


def test_the_same_comparison_at_every_point_that_both_algorithms_have(sweep):
    [found] = [one for one in studies(collect(sweep), reported_experiments()) if one.factors]
    rows = list(repeated(found, FRESH))
    assert [(one.changes, one.direction) for one in rows] == [
        ("", "base"),
        ("swarm.speed=4.0", "same"),
        ("swarm.clearance=4.0", "other"),
    ]
    assert [one.comparison.difference for one in rows] == pytest.approx([0.2, 0.1, -0.2])
    assert {(one.place, one.against, one.comparison.count) for one in rows} == {
        (cell_named("open_short"), "no_exchange", 4)
    }
    assert [row[2] for row in robustness_table(found, FRESH).rows] == [
        "as they are",
        "swarm.speed=4.0",
        "swarm.clearance=4.0",
    ]


def test_the_report_prints_and_keeps_them(sweep):
    place = write_report(sweep).folder
    with (place / "sweep_fresh_robustness.csv").open(encoding="utf-8") as file:
        assert [row["direction"] for row in csv.DictReader(file)] == ["base", "same", "other"]
    page = (place / "sweep_report.md").read_text()
    assert "SLCS2 less the other algorithm, under each setting, winner's mean over fresh deployments" in page


def test_without_the_base_there_is_no_direction(make):
    for speed, clearance in ((2.0, 2.0), (4.0, 2.0), (2.0, 4.0)):
        for arm in ("slcs2", "no_exchange")[: 1 if speed == clearance else 2]:
            own = {"swarm": {"speed": speed, "clearance": clearance}}
            type(make)(make.root / f"{speed}_{clearance}").evolved(arm, "open_short", 0, [0.5], fresh=0.5, **own)
    [found] = [one for one in studies(collect(make.root), reported_experiments()) if one.factors]
    assert [one.direction for one in repeated(found, FRESH)] == [None, None]


def test_one_algorithm_has_nothing_to_compare(make):
    for speed in (2.0, 4.0):
        other = type(make)(make.root / f"{speed}")
        other.evolved("slcs2", "open_short", 0, [0.5], fresh=0.5, swarm={"speed": speed})
    [found] = studies(collect(make.root), reported_experiments())
    assert not robustness_table(found, FRESH).rows
