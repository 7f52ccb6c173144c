"""The matrix of transfer, and each row against the designed behaviour and the best specialist from elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from slcs2_jax.looking import drawing
from slcs2_jax.study.transfer import BEHAVIOUR, GENERALIST, SPECIALIST, Source, contests_table, matrix_table
from slcs2_jax.study.transfer_figure import transfer_figure

RNG = np.random.default_rng(0)
WORTH = {kind: RNG.normal(size=12) for kind in ("open/short", "urban/short")}


def source(name: str, role: str, home: str, levels: tuple[float, float], winners: int = 3, quality: str = "") -> Source:
    fitness = {
        kind: level + worth + RNG.normal(0, 0.02, (winners, 12))
        for level, (kind, worth) in zip(levels, WORTH.items(), strict=True)
    }
    return Source(name, role, home, quality, fitness)


SOURCES = [
    source("short open", SPECIALIST, "open/short", (0.9, 0.1), quality="kept"),
    source("short open", SPECIALIST, "open/short", (0.8, 0.2), quality="forgotten"),
    source("short urban", SPECIALIST, "urban/short", (0.5, 0.5)),
    source("8 worlds", GENERALIST, "", (0.85, 0.45)),
    source("designed", BEHAVIOUR, "", (0.7, -0.2), winners=1),
]


def test_the_matrix_has_means_over_winners_and_worlds():
    table = matrix_table(SOURCES)
    assert table.header[-3:] == ("open/short", "urban/short", "all")
    for one, row in zip(SOURCES, table.rows, strict=True):
        assert row[:4] == (one.name, one.role, one.quality or None, 1 if one.role == BEHAVIOUR else 3)
        assert row[4:6] == pytest.approx([values.mean() for values in one.fitness.values()])
        assert row[6] == pytest.approx(np.mean(row[4:6]))


def test_rows_are_compared_world_by_world():
    table = contests_table(SOURCES)
    rows = {(row[0], row[1], row[3]): dict(zip(table.header, row, strict=True)) for row in table.rows}
    made = rows["urban/short", "8 worlds", None]
    mine, its = (SOURCES[at].by_world("urban/short") for at in (3, 4))
    assert made["less designed"] == pytest.approx((mine - its).mean())
    assert made["Wilcoxon p, designed"] == pytest.approx(stats.wilcoxon(mine - its).pvalue)
    assert made["permutation p, designed"] < made["Holm p, designed"] < 0.01
    assert made["best specialist from elsewhere"] == "short open, quality forgotten"  # that of urban is at home
    assert rows["open/short", "8 worlds", None]["best specialist from elsewhere"] == "short urban"
    assert rows["all", "8 worlds", None]["best specialist from elsewhere"] is not None
    assert rows["open/short", "designed", None]["less designed"] is None
    assert rows["all", "designed", None]["n"] == 24


def test_the_heat_map_is_the_same_each_time(tmp_path):
    for name in ("one", "other"):
        drawing.save(lambda: transfer_figure(SOURCES), tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "other.png").read_bytes()
