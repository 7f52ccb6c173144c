"""The page in a real browser: it loads without a complaint, plays and scrubs, its table sorts and searches.

Left out where there is no browser: see the fixture `browser`.
"""

from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.looking.page import write_page
from slcs2_jax.looking.page_entries import chosen, entries
from slcs2_jax.results import read_run


@pytest.fixture(scope="session")
def file(finished, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    run = read_run(finished)
    write_page(path, "A run", entries(run, replayed=chosen([run], 1), deployment=0))
    return path


@pytest.fixture(params=["light", "dark"])
def page(browser, file, request):
    context = browser.new_context(color_scheme=request.param, viewport={"width": 1000, "height": 800})
    opened = context.new_page()
    complaints, asked = [], []
    opened.on("console", lambda message: complaints.append(message.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda request: asked.append(request.url))
    opened.goto(file.as_uri())
    opened.wait_for_selector("body[data-ready]", timeout=10_000)
    yield opened
    assert complaints == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    context.close()


def drawn(page) -> str:
    return page.locator("#replay canvas").evaluate("canvas => canvas.toDataURL()")


def time_step(page) -> str:
    return page.locator("#time").text_content()


def test_it_plays_pauses_and_goes_on_by_itself(page):
    before = drawn(page)
    assert time_step(page).startswith("time-step 0: delivered 0 of 4")
    page.locator("#play").click()
    page.wait_for_function("player.frame > 10")
    page.locator("#play").click()
    stopped = time_step(page)
    page.wait_for_timeout(300)
    assert time_step(page) == stopped
    assert drawn(page) != before


def test_it_scrubs_and_ends_where_the_episode_ends(page, episode):
    slider = page.locator("input[type=range]")
    slider.evaluate("e => { e.value = e.max; e.dispatchEvent(new Event('input')); }")
    assert time_step(page).startswith(f"time-step {episode.steps}: delivered {episode.delivered[-1]} of 4")


def test_it_works_from_the_keyboard(page):
    page.locator("#replay canvas").focus()
    for key, begins in (("ArrowRight", "time-step 1:"), ("ArrowLeft", "time-step 0:")):
        page.keyboard.press(key)
        assert time_step(page).startswith(begins)
    page.keyboard.press("]")
    assert "Agent 1" in page.locator("#watched").text_content()
    page.keyboard.press("+")
    assert page.get_by_label("frames per second").input_value() == "40"
    page.keyboard.press(" ")
    assert page.locator("#play").text_content() == "Pause"
    page.keyboard.press(" ")
    assert page.locator("#play").text_content() == "Play"


def test_pointing_at_an_agent_tells_its_rule(page, episode):
    page.locator("input[type=range]").evaluate("e => { e.value = e.max; e.dispatchEvent(new Event('input')); }")
    agent = 2
    place = page.evaluate(f"nodePlace(player.replay, {agent}, player.frame)")
    assert place == pytest.approx([episode.x[-1, agent], episode.y[-1, agent]], abs=0.06)
    x, y = page.evaluate(f"player.scene.point(nodePlace(player.replay, {agent}, player.frame))")
    page.locator("#replay canvas").hover(position={"x": x, "y": y})
    watched = int(page.evaluate("player.watched"))
    places = np.hypot(episode.x[-1] - episode.x[-1, agent], episode.y[-1] - episode.y[-1, agent])
    assert places[watched] < 1, "another agent, and not one in the same place"
    said = page.locator("#watched").text_content()
    rule = episode.rule[-1, watched]
    assert (f"rule {rule}: {episode.rules.text(watched, int(rule))}" if rule >= 0 else "no rule was drawn") in said


def test_the_table_sorts_and_searches(page):
    def column(number: int) -> list[str]:
        return page.locator(f"#rules tbody td:nth-child({number})").all_text_contents()

    strength = [float(text) for text in column(3)]
    assert len(strength) == 36
    assert strength == sorted(strength, reverse=True)
    for ascending in (False, True):
        page.get_by_role("button", name="use τ").click()
        use = [int(text) for text in column(6)]
        assert use == sorted(use, reverse=not ascending)
    page.get_by_role("searchbox").fill("move")
    found = column(2)
    assert 0 < len(found) < 36
    assert all("move" in rule for rule in found)
    page.get_by_label("of", exact=True).select_option("agent 1")
    assert set(column(1)) <= {"1"}


def test_another_instance_is_shown_when_it_is_chosen(page):
    page.locator("#instances tbody button").nth(1).click()
    page.wait_for_function("document.querySelector('#replay').textContent.includes('not replayed')")
    assert page.locator("#summary .note").count() == 1
    page.wait_for_function("document.querySelectorAll('#search canvas').length >= 3")


def test_light_and_dark_are_each_a_click_away(page):
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    picture = drawn(page)
    page.locator("#theme").click()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before
    assert drawn(page) != picture
