"""Responses to settings and their interactions, by hand; and the tables that print them."""

import csv
import io

import numpy as np
import pytest

from slcs2_jax.results.arm import cell_named
from slcs2_jax.study.collect import collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.response import grids, responses
from slcs2_jax.study.response_table import (
    differences_table,
    grid_table,
    grids_table,
    interactions_table,
    responses_table,
    shared_table,
)
from slcs2_jax.study.study import BEST, FRESH, studies

OPEN = cell_named("open_short")
LEVEL = {(2.0, -94.0): 0.1, (4.0, -94.0): 0.3, (2.0, -90.0): 0.2, (4.0, -90.0): 0.7}


@pytest.fixture
def sweep(make):
    for (speed, noise), level in LEVEL.items():
        for seed in range(4):
            best = level + seed / 100 + (seed == 3) * (speed - 2.0) / 20
            own = {"swarm": {"speed": speed}, "radio": {"noise_dbm": noise}}
            other = type(make)(make.root / f"{speed}_{noise}")
            other.evolved("slcs2", "open_short", seed, [best - 0.5, best], fresh=best - 0.05, **own)
    [found] = studies(collect(make.root), reported_experiments())
    return found


def test_a_sweep_is_a_study_of_its_own(sweep):
    assert (sweep.name, sweep.title) == ("sweep", "Sweep over radio.noise_dbm, swarm.speed")
    assert sweep.arms == (
        "slcs2",
        "slcs2 at radio.noise_dbm=-90.0",
        "slcs2 at swarm.speed=4.0",
        "slcs2 at radio.noise_dbm=-90.0, swarm.speed=4.0",
    )
    assert sweep.missing == ()


@pytest.mark.parametrize(("metric", "shift"), [(BEST, 0.0), (FRESH, -0.05)])
def test_one_setting_changes_and_the_others_stay(sweep, metric, shift):
    noise, speed = responses(sweep, metric)
    assert [level.value for level in noise.levels] == [-94.0, -90.0]
    assert noise.levels[0].effect is None
    assert noise.levels[1].effect.difference == pytest.approx(0.1)
    assert [level.description.mean for level in speed.levels] == pytest.approx([0.115 + shift, 0.315 + 0.025 + shift])
    effect = speed.levels[1].effect
    assert (effect.count, effect.difference, effect.a12) == (4, pytest.approx(0.225), 1.0)
    assert effect.p_holm == pytest.approx(2 * effect.p_mann_whitney)  # two effects in the family


def test_two_settings_together(sweep):
    [grid] = grids(sweep, BEST)
    assert (grid.rows.name, grid.columns.name, grid.count) == ("radio.noise_dbm", "swarm.speed", 4)
    assert grid.means[-90.0, 4.0] == pytest.approx(0.715 + 0.025)
    [one] = grid.interactions
    assert (one.row, one.column) == (-90.0, 4.0)
    assert one.value == pytest.approx(0.7 - 0.3 - 0.2 + 0.1)  # what each instance adds by itself falls out


def test_only_the_instances_that_all_values_have(make):
    for speed in (2.0, 4.0):
        for seed in range(2 if speed == 2.0 else 3):
            other = type(make)(make.root / str(speed))
            other.evolved("slcs2", "open_short", seed, [speed / 10 + seed], swarm={"speed": speed})
    [study] = studies(collect(make.root), reported_experiments())
    [response] = responses(study, BEST)
    assert [level.description.count for level in response.levels] == [2, 2]
    assert response.levels[1].effect.difference == pytest.approx(0.2)
    assert grids(study, BEST) == ()


def test_an_experiment_of_the_paper_is_judged_without_the_changed_runs(make):
    for seed in range(4):
        make.evolved("slcs2", "open_short", seed, [0.5])
        make.evolved("ailta", "open_short", seed, [0.1])
        type(make)(make.root / "fast").evolved("slcs2", "open_short", seed, [0.9], swarm={"speed": 4.0})
    first, second = studies(collect(make.root), reported_experiments())
    assert (first.name, first.arms) == ("contributions", ("slcs2", "ailta"))
    assert list(first.sample("slcs2", OPEN, BEST)) == [0.5] * 4
    assert second.arms == ("slcs2", "slcs2 at swarm.speed=4.0", "ailta")
    assert [len(one.levels) for one in responses(second, BEST)] == [2]


def rows(table):
    return list(csv.DictReader(io.StringIO(table.csv())))


def test_tables(sweep):
    [noise, speed] = rows(differences_table(sweep.outcomes, sweep.factors))
    assert (speed["setting"], speed["instances"], speed["unit"]) == ("swarm.speed", "8 at 2.0, 8 at 4.0", "m/step")
    assert (noise["compared with"], noise["default"]) == ("-94.0", "-94.0")
    assert shared_table(sweep.outcomes).rows == ()
    found = rows(responses_table(sweep, FRESH))
    assert [(row["setting"], row["value"], row["base"]) for row in found] == [
        ("radio.noise_dbm", "-94.0", "base"),
        ("radio.noise_dbm", "-90.0", ""),
        ("swarm.speed", "2.0", "base"),
        ("swarm.speed", "4.0", ""),
    ]
    assert float(found[3]["less the base"]) == pytest.approx(0.225)
    assert "fresh" in responses_table(sweep, FRESH).title
    [grid] = grids(sweep, BEST)
    assert grid_table(grid).header == ("radio.noise_dbm", "swarm.speed=2.0", "swarm.speed=4.0")
    np.testing.assert_allclose([row[1:] for row in grid_table(grid).rows], [[0.115, 0.34], [0.215, 0.74]])
    assert len(rows(grids_table(sweep, BEST))) == 4
    [one] = rows(interactions_table(sweep, BEST))
    assert float(one["beyond the sum"]) == pytest.approx(0.3)
