"""Several and moving jammers, and agents that are down: in a recording, on maps and in pictures."""

from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.looking.radio_map import field, grid, received
from slcs2_jax.looking.recording import NOBODY
from slcs2_jax.looking.scene import DOWN, EMPTY, HOLDING, JAMMER, Scene, agent_faces, extent, legend_handles, panels
from slcs2_jax.looking.still import PICTURES, still

WITHIN = (-20.0, 170.0, -110.0, 110.0)


def test_the_recording_has_where_each_jammer_was_and_what_it_did(troubled_episode):
    one = troubled_episode
    steps = one.steps
    assert one.jammer_x.shape == one.jammer_y.shape == (steps + 1, 3)
    assert one.jammed.shape == (steps, 3)
    for number, jammer in enumerate(one.scenario.jammers):
        there, back = jammer.place.astype(float), jammer.route[0].astype(float)
        length = np.hypot(*(back - there))
        gone = 2.0 * np.arange(steps + 1) % (2 * length)
        share = np.minimum(gone, 2 * length - gone) / length
        expected = there + share[:, None] * (back - there)
        np.testing.assert_allclose(one.jammer_x[:, number], expected[:, 0], atol=0.01)
        np.testing.assert_allclose(one.jammer_y[:, number], expected[:, 1], atol=0.01)
        np.testing.assert_array_equal(one.jammed[:, number], (np.arange(steps) // 7 + number) % 3)


def test_who_is_down_does_nothing(troubled_episode):
    one = troubled_episode
    assert 0.05 < one.down.mean() < 0.8
    down = one.down[:-1]
    assert (one.action[down] == 255).all()
    assert (one.rule[down] == NOBODY).all()
    assert (one.sent_to[down] == NOBODY).all()
    for step in range(0, one.steps, 5):
        heard = one.neighbours(step)
        assert not heard[:, one.down[step]].any()
        assert not heard[:4][one.down[step]].any()
    held = one.holding.sum(axis=1)
    lost = 4 - one.waiting - held - one.delivered
    assert (np.diff(lost) >= 0).all()


def test_worlds_with_one_or_none_have_one_column_or_none(episode, jammed_episode):
    assert episode.jammer_x.shape == (episode.steps + 1, 0)
    assert jammed_episode.jammer_x.shape == (jammed_episode.steps + 1, 1)
    assert (jammed_episode.jammer_x[:, 0] == jammed_episode.scenario.jammer[0]).all()
    assert not jammed_episode.down.any()


def test_a_map_adds_the_jammers_that_are_on_the_channel_then_and_leaves_out_who_is_down(troubled_episode):
    one = troubled_episode
    x, y = grid(WITHIN)
    moment = int(np.flatnonzero(one.down.any(axis=1) & ~one.down.all(axis=1))[0])
    senders = [(0.0, 0.0), *[one.place(moment, agent) for agent in range(4) if not one.down[moment, agent]]]
    power = received(one, senders, x, y).max(axis=0)
    on = [jammer for jammer in range(3) if one.jammed[moment, jammer] == one.channels[0]]
    assert len(on) == 1
    noise = 10 ** (one.settings.radio.noise_dbm / 10)
    for jammer in on:
        noise = noise + 10**-0.3 * received(one, [one.jammer_places(moment)[jammer]], x, y)[0]
    np.testing.assert_allclose(field(one, "power", moment, WITHIN), 10 * np.log10(power), atol=1e-6)
    np.testing.assert_allclose(field(one, "sinr", moment, WITHIN), 10 * np.log10(power / noise), atol=1e-6)


def test_the_reach_is_that_of_its_power(troubled_episode, jammed_episode):
    net = troubled_episode.settings.radio.network_range
    assert troubled_episode.reach(0) == pytest.approx(net * 10 ** (-3 / 28))
    assert jammed_episode.reach(0) == pytest.approx(jammed_episode.settings.radio.network_range)


def test_a_scene_moves_the_jammers_and_shows_who_is_down(troubled_episode):
    one = troubled_episode
    _, [axes] = panels([one], None)
    scene = Scene(axes, one, "", extent([one]), None)
    marks = [artist for artist in axes.lines if artist.get_marker() == "X"]
    assert len(marks) == 3
    assert set(marks) <= set(scene.moving)
    for moment in (0, 10, one.steps):
        scene.show(moment, moment)
        for mark, place in zip(marks, one.jammer_places(moment), strict=True):
            assert (mark.get_xdata()[0], mark.get_ydata()[0]) == pytest.approx(place)
        faces = agent_faces(one, moment)
        for agent, face in enumerate(faces):
            held, down = one.holding[moment, agent], one.down[moment, agent]
            assert face == (DOWN if down else HOLDING if held else EMPTY)
    texts = [text.get_text() for text in axes.texts]
    assert {"jammer 0", "jammer 1", "jammer 2"} <= set(texts)
    assert len(legend_handles(failing=True)) == len(legend_handles()) + 1


def test_one_that_stays_and_answers_is_drawn_once(jammed_episode):
    one = jammed_episode
    _, [axes] = panels([one], None)
    scene = Scene(axes, one, "", extent([one]), None)
    marks = [artist for artist in axes.lines if artist.get_marker() == "X"]
    assert len(marks) == 1
    assert not set(marks) & set(scene.moving)


@pytest.mark.parametrize("picture", PICTURES)
def test_pictures_show_them_with_their_ways(troubled_episode, picture):
    one = troubled_episode
    figure = still([one], [""], picture, start=0, end=50, field="sinr")
    axes = figure.axes[0]
    ways = [line for line in axes.lines if str(line.get_color()) == JAMMER and len(line.get_xdata()) == 51]
    assert len(ways) == 3
    figure.canvas.draw()
