"""Rows and winners of results made by hand; the page of them in a browser."""

from __future__ import annotations

import re

import numpy as np
import pytest

from slcs2_jax.suite.page import about, tables, write_all
from slcs2_jax.suite.rows import HEADER, as_markdown, printed, row, winners
from slcs2_jax.suite.statistics import Estimate
from slcs2_jax.suite.table import collect
from tests.suite.test_measured import result


def saved(root, world, entry, delivered, steps, **changes):
    """One training; delivered and steps of each of three worlds, the same in two deployments."""
    arrays = {
        name: np.repeat(np.array(values, np.int32)[None, :, None], 2, axis=2)
        for name, values in (("delivered", delivered), ("steps", steps))
    }
    result(world, entry, title=f"<b>{entry}</b>", **arrays, **changes).save(root)


@pytest.fixture
def table(tiny, tmp_path):
    few, short = tiny.worlds["few"], tiny.worlds["open_short"]
    for world in (few, short):
        saved(tmp_path, world, "designed", [6, 6, 6], [300, 330, 360], episodes=0, env_steps=0, field="hand-made")
        saved(tmp_path, world, "slcs2", [6, 6, 6], [60, 90, 600], field="evolved")
    saved(tmp_path, few, "mine", [6, 0, 0], [60, 600, 600])
    return collect(tiny, [tmp_path], list(tiny.worlds.values()))


def test_a_row_counts_kinds_of_worlds_alike_and_says_what_was_spent(table):
    found = row(table, "slcs2", ["open_short", "few"])
    assert tuple(found) == HEADER
    assert found["fitness"].value == pytest.approx((0.9 + 0.85 + 0.0) / 3)
    assert found["delivered"] == 1.0
    assert found["time"] == pytest.approx(750 / 1800)
    assert found["better than"].value == pytest.approx(2 / 3)
    assert found["gap to the bound"] == pytest.approx(np.mean(list(table.bounds.values())) - found["fitness"].value)
    assert (found["worlds"], found["deployments"], found["episodes spent"], found["env-steps spent"]) == (
        6,
        12,
        10,
        140,
    )
    assert found["between trainings"] is None
    assert row(table, "designed", ["few"])["better than"] is None


def test_nothing_is_said_over_worlds_that_an_entry_was_not_in(table):
    overall = tables(table)["overall"][2]
    assert [line[0]["text"] for line in overall] == ["<b>designed</b>", "<b>slcs2</b>"]
    assert any("<b>mine</b>: in 1 of 2 of them" in line for line in about(table))


def test_winners_are_named_with_a_corrected_test(table):
    few = next(one for one in winners(table) if one["world"] == "Four agents only")
    assert few["best"] == "<b>slcs2</b>"
    assert few["second"] == "<b>designed</b>"
    assert few["ahead by"] == pytest.approx((0.9 + 0.85) / 3 - (0.5 + 0.45 + 0.4) / 3)
    assert few["p (Holm)"] == 1.0  # three worlds decide nothing
    assert few["not significantly worse"] == "<b>designed</b>, <b>mine</b>"


def test_fewer_worlds_may_be_looked_at(tiny, tmp_path, table):
    found = collect(tiny, [tmp_path], [tiny.worlds["few"]], seeds=2, only=["slcs2"])
    assert list(found.entries) == ["slcs2"]
    assert found.scores("slcs2", "few").tolist() == pytest.approx([0.9, 0.85])


def test_how_figures_are_printed():
    assert printed(Estimate(0.5, 0.25, 0.75)) == "0.500 [0.250, 0.750]"
    assert [printed(value) for value in (None, 0.0, 1e-5, 1234567, "x")] == ["–", "0.000", "1.0e-05", "1,234,567", "x"]
    assert as_markdown(["a|b"], [["<i>"]]) == "| a\\|b |\n| --- |\n| \\<i> |\n"


def test_titles_are_text_in_markdown(table, tmp_path):
    write_all(tmp_path, table)
    text = (tmp_path / "table.md").read_text()
    assert "\\<b>mine\\</b>: in 1 of 2 of them" in text
    assert not re.search(r"(?<!\\)</?b>", text)


def test_the_page_sorts_and_says_titles_as_text(table, tmp_path, browser):
    write_all(tmp_path, table)
    page = browser.new_page()
    complaints = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto((tmp_path / "index.html").as_uri())
    page.wait_for_selector("body[data-ready]", timeout=10_000)
    first = page.locator("#tables table").first

    def names():
        return first.locator("tbody tr td:first-child").all_inner_texts()

    assert names() == ["<b>designed</b>", "<b>slcs2</b>"]
    first.get_by_role("button", name="fitness").click()
    assert names() == ["<b>slcs2</b>", "<b>designed</b>"]
    first.get_by_role("button", name="fitness").click()
    assert names() == ["<b>designed</b>", "<b>slcs2</b>"]
    assert page.locator("#figures figure").count() == 2
    assert page.locator("#watch").is_hidden()
    assert complaints == []
    page.close()
