"""The page of a study: what it says; and in a real browser, that it draws, downloads and leads to the runs' pages.

Needs Chromium (CHROMIUM names one) for the latter; left out where there is none, unless SLCS2_BROWSER=required.
"""

from __future__ import annotations

import base64
import csv
import io
import json
import re
import shutil
import xml.etree.ElementTree as ElementTree
import zlib

import pytest

from slcs2_jax import cli

SVG = "{http://www.w3.org/2000/svg}"


def index_of(text: str) -> dict:
    name = re.search(r'data-index="([^"]+)"', text)[1]
    data = re.search(rf'id="{name}">([^<]*)<', text)[1]
    return json.loads(zlib.decompress(base64.b64decode(data)))


@pytest.fixture
def report(make, capsys):
    """Two algorithms and two speeds in one world."""
    for arm, level in (("slcs2", 0.3), ("ailta", 0.1)):
        for speed in (2.0, 4.0):
            for seed in range(4):
                best = level + speed / 20 + seed / 100
                own = {"swarm": {"speed": speed}}
                # the better a search's own best, the worse its fresh mean
                type(make)(make.root / f"speed_{speed}").evolved(
                    arm, "open_short", seed, [best - 0.2, best], fresh=0.1 - best, **own
                )
    assert cli.main(["report", str(make.root), "replays=0"]) == 0
    return make.root / "report" / "report.html"


def test_what_it_says(report):
    index = index_of(report.read_text())
    fresh = [one["fresh"] for one in index["runs"]]
    assert fresh == sorted(fresh, reverse=True)
    assert index["runs"][0]["best"] == min(one["best"] for one in index["runs"])
    for one in index["runs"]:
        assert (report.parent / one["page"]).is_file()
    contributions, sweep = index["studies"]
    by_name = {one["name"]: one for one in contributions["figures"] + sweep["figures"]}
    effects = by_name["contributions_fresh_effects"]
    assert (effects["metric"], effects["series"][0]["ys"], effects["level"]) == ("fresh", [0.0], 0.5)
    speed = by_name["sweep_open_short_slcs2_swarm_speed_best"]
    assert speed["xs"] == [2.0, 4.0]
    assert speed["series"][0]["ys"] == pytest.approx([0.415, 0.515])
    assert speed["series"][0]["low"][0] < 0.415 < speed["series"][0]["high"][0]
    curve = by_name["contributions_open_short_curves"]
    assert (curve["metric"], curve["xs"]) == (None, [1, 2])
    for one in by_name.values():
        assert one["metric"] is None or ("fresh" in one["caption"] + one["title"]) == (one["metric"] == "fresh")
    assert index["differs"][0]["rows"][0][0] == "swarm.speed"
    assert list(index["metrics"]) == ["fresh", "best"]


def test_pages_of_runs_that_are_gone_are_removed(report, make):
    old = report.parent / index_of(report.read_text())["runs"][0]["page"]
    mine = old.with_name("mine.html")
    mine.write_text("mine")
    shutil.rmtree(make.root / "speed_4.0")
    shutil.rmtree(make.root / "speed_2.0" / "ailta")
    kept = [one["page"] for one in index_of(report.read_text())["runs"]]
    assert cli.main(["report", str(make.root), "replays=0"]) == 0
    left = [one["page"] for one in index_of(report.read_text())["runs"]]
    assert len(left) == 4 < len(kept)
    assert sum((report.parent / page).exists() for page in kept) == 4
    assert mine.read_text() == "mine"


@pytest.fixture
def page(report, browser):
    opened = browser.new_page(viewport={"width": 420, "height": 800}, color_scheme="dark")
    complaints, asked = [], []
    opened.on("console", lambda message: complaints.append(message.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda request: asked.append(request.url))
    opened.goto(report.as_uri())
    opened.wait_for_selector("body[data-ready]", timeout=10_000)
    yield opened
    assert complaints == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    opened.close()


def downloaded(page, figure, button: str) -> str:
    with page.expect_download() as found:
        figure.get_by_role("button", name=button).click()
    return found.value.path().read_text("utf-8")


def test_in_a_browser(page, report):
    index = index_of(report.read_text())
    assert page.evaluate("document.documentElement.scrollWidth") <= 420  # narrow, and nothing sticks out
    shown = [one for study in index["studies"] for one in study["figures"] if one["metric"] != "best"]
    figures = page.locator("figure")
    assert figures.count() == len(shown)
    kinds = [at for at, one in enumerate(shown) if at < 3 or "swarm_speed" in one["name"]][:4]  # Chromium allows ten
    for at, one in [(at, shown[at]) for at in kinds]:
        drawing = ElementTree.fromstring(downloaded(page, figures.nth(at), "SVG"))
        texts = {text.text for text in drawing.iter(f"{SVG}text")}
        assert {one["title"], one["x"]["label"], one["y"]["label"]} <= texts
        assert {each["label"] for each in one["series"]} <= texts
        coloured = {path.get("stroke") for path in drawing.iter(f"{SVG}path")}
        assert "#0072b2" in coloured  # in light colours, and what is drawn is there
        head, *rows = csv.reader(io.StringIO(downloaded(page, figures.nth(at), "CSV")))
        assert head[:2] == [one["x"]["label"], one["series"][0]["label"]]
        assert [float(row[1]) for row in rows] == one["series"][0]["ys"]
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.locator("#metric").select_option("best")
    assert page.locator("figure h3").first.text_content() == "Fitness: best fitness of the search"
    page.locator("#theme").focus()
    page.keyboard.press("Enter")
    assert page.evaluate("document.documentElement.dataset.theme") == "light"
    page.locator("#runs a").first.click()
    page.wait_for_selector("#summary dl")
    assert index["runs"][0]["page"].split("/")[-1] in page.url
