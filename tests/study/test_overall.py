"""One test for each arm over all worlds, pair by pair."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from slcs2_jax.results.arm import CELLS, cell_named
from slcs2_jax.study.collect import collect
from slcs2_jax.study.overall import overall, overall_table, pairs
from slcs2_jax.study.statistics import permuted
from slcs2_jax.study.study import FRESH, studies

ARMS = {"contributions": ("Contributions", ("slcs2", "ailta", "no_exchange"))}


def test_instances_are_pairs_whatever_their_world(make):
    rng = np.random.default_rng(0)
    worth = {"open_short": 0.5, "urban_long": -0.5}
    for cell, level in worth.items():
        for seed in range(6):
            shared = level + rng.normal(0, 0.3)
            for arm, better in (("slcs2", 0.1), ("ailta", 0.0), ("no_exchange", 0.08)):
                make.evolved(arm, cell, seed, [0.9], fresh=shared + better + rng.normal(0, 0.02))
    make.evolved("slcs2", "open_long", 0, [0.9], fresh=0.3)  # without a partner
    [study] = studies(collect(make.root), ARMS)
    mine, its = pairs(study, "ailta", CELLS, FRESH)
    assert len(mine) == 12
    found = {arm: (one, p) for arm, one, p in overall(study, CELLS, FRESH)}
    one, corrected = found["ailta"]
    assert one.p_wilcoxon == pytest.approx(stats.wilcoxon(mine - its).pvalue)
    assert one.difference == pytest.approx((mine - its).mean())
    raw = sorted(other.p_wilcoxon for other, _ in found.values())
    assert corrected == pytest.approx(min(1.0, 2 * raw[0]) if one.p_wilcoxon == raw[0] else max(2 * raw[0], raw[1]))
    assert one.p_mann_whitney > 0.1  # worlds hide it, pairs do not
    assert corrected < 0.01
    assert len(pairs(study, "ailta", (cell_named("urban_long"),), FRESH)[0]) == 6


def test_the_table_has_all_worlds_and_each_range(make):
    for seed in range(3):
        for arm, fresh in (("slcs2", 0.3), ("ailta", 0.2 + 0.1 * seed)):
            make.evolved(arm, "open_short", seed, [0.9], fresh=fresh)
            make.evolved(arm, "open_long", seed, [0.9], fresh=fresh - 0.1 * (arm == "slcs2"))
    [study] = studies(collect(make.root), ARMS)
    rows = {row[0]: row[1:6] for row in overall_table(study, FRESH).rows}
    assert rows.keys() == {"all", "all short", "all long"}
    assert rows["all"][:4] == ("no novelty (AILTA)", 6, 2, 1)
    assert rows["all short"][3] == 1
    assert rows["all long"][3] == 0
    assert rows["all"][4] == pytest.approx(-0.05)


def test_ranks_and_means_can_point_to_different_sides():
    x, y = np.zeros(20), np.full(20, 0.05)
    y[:3] = -0.9  # a little better in most pairs, far worse in three
    assert stats.wilcoxon(x - y).pvalue < 0.1
    assert (x - y).mean() > 0
    assert permuted(x, y) > 0.1
    assert permuted(x, y) == permuted(x, y)
    assert permuted(x, y - 1) < 0.001
    assert permuted(x, x) == 1.0
    assert permuted(x[:1], y[:1]) is None
