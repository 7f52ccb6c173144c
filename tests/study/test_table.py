"""Tables in their three forms."""

import csv
import io

from slcs2_jax.results.arm import cell_named
from slcs2_jax.study.collect import collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.statistics import Interval
from slcs2_jax.study.study import BEST, studies
from slcs2_jax.study.table import Table, comparisons_table, descriptions_table, failures_table, runs_table

TABLE = Table("Of 50 %", ("name", "n", "CI90"), (("a_b", 0.12345, Interval(0.1, 0.98765)), ("c", None, None)))


def test_markdown_rounds_and_aligns():
    lines = TABLE.markdown().splitlines()
    assert lines[0] == "**Of 50 %**"
    assert [cell.strip() for cell in lines[4].split("|")[1:-1]] == ["a_b", "0.123", "[0.100, 0.988]"]
    assert [cell.strip() for cell in lines[5].split("|")[1:-1]] == ["c", "-", "-"]


def test_latex_escapes_what_latex_would_read():
    text = TABLE.latex()
    assert r"\caption{Of 50 \%}" in text
    assert text.count("{") == text.count("}")
    assert r"a\_b" in text
    assert r"\toprule" in text


def test_csv_keeps_every_digit():
    assert list(csv.reader(io.StringIO(TABLE.csv()))) == [
        ["name", "n", "CI90 low", "CI90 high"],
        ["a_b", "0.12345", "0.1", "0.98765"],
        ["c", "", "", ""],
    ]


def test_a_row_for_each_run(make):
    make.evolved("slcs2", "open_short", 0, [0.25, 0.5], fresh=0.375)
    make.evolved("ailta", "open_short", 0, [0.125], planned=2)
    rows = list(csv.DictReader(io.StringIO(runs_table(collect(make.root), make.root).csv())))
    assert [(r["arm"], r["generations"], r["best fitness"], r["fresh mean"], r["folder"]) for r in rows] == [
        ("ailta", "1", "0.125", "", "ailta/open_short/seed_000"),
        ("slcs2", "2", "0.5", "0.375", "slcs2/open_short/seed_000"),
    ]


def test_the_papers_figures_stand_beside_ours(make):
    for arm, best in (("slcs2", 0.5), ("ailta", 0.75)):
        for seed in range(2):
            make.evolved(arm, "urban_jammed_long", seed, [best])
    [study] = studies(collect(make.root), reported_experiments())
    rows = list(csv.DictReader(io.StringIO(descriptions_table(study).csv())))
    assert [(row["world"], row["best mean"], row["paper"]) for row in rows] == [
        ("long urban jammed", "0.5", "0.193"),
        ("long urban jammed", "0.75", "-0.677"),
    ]
    [row] = csv.DictReader(io.StringIO(comparisons_table(study, BEST).csv()))
    assert (row["difference"], row["A12"]) == ("-0.25", "0.0")
    assert row["superior (the paper's rule)"] == "no novelty (AILTA), non-significantly"


def test_failures_of_winners_and_of_the_designed_behaviour_are_counted_alike(make):
    for seed in range(2):
        make.evolved("slcs2", "open_short", seed, [0.5], fresh=0.4, failed=0.1 * seed)
        make.designed("open_short", seed, [-1.0, 0.2, 0.3, 0.4])
    [study] = studies(collect(make.root), reported_experiments())
    rows = list(csv.DictReader(io.StringIO(failures_table(study).csv())))
    assert [row["failed single deployments"] for row in rows] == ["0.05", "0.25"]
    make.evolved("slcs2", "open_short", 2, [0.5], fresh=0.4)  # did not keep it
    make.designed("open_short", 2, [0.5])
    [study] = studies(collect(make.root), reported_experiments())
    assert study.failed_deployments("slcs2", cell_named("open_short")) is None
