"""Radio maps against the formulas of the model, written out, and walls counted by Shapely."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString

from slcs2_jax.looking.radio_map import MOST_PLACES, field, grid, received

WITHIN = (-20.0, 130.0, -60.0, 60.0)


def decibels(recording, sender, x, y) -> float:
    """P_t - PL(d) - walls * L_w."""
    scenario, radio = recording.scenario, recording.settings.radio
    link = LineString([sender, (x, y)])
    walls = [LineString([(at, low), (at, high)]) for at, low, high in scenario.vertical.tolist()]
    walls += [LineString([(low, at), (high, at)]) for at, low, high in scenario.horizontal.tolist()]
    crossed = sum(link.intersects(wall) for wall in walls)
    loss = radio.reference_loss_db + 10 * radio.path_loss_exponent * np.log10(max(link.length, 1.0))
    return radio.power_dbm - loss - crossed * radio.wall_loss_db


def test_power_is_that_of_the_model(jammed_episode):
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-20, 130, 300), rng.uniform(-60, 60, 300)
    for sender, found in zip(
        ((7.0, -3.0), (90.0, 20.0)), received(jammed_episode, [(7, -3), (90, 20)], x, y), strict=True
    ):
        expected = [decibels(jammed_episode, sender, *place) for place in zip(x, y, strict=True)]
        np.testing.assert_allclose(10 * np.log10(found), expected, atol=1e-3)
    without = [decibels(jammed_episode, (7.0, -3.0), *place) for place in zip(x, y, strict=True)]
    assert len(np.unique(np.rint(without))) > 20


def test_the_strongest_sender_counts_and_the_jammer_disturbs(jammed_episode):
    one = jammed_episode
    power, sinr = (field(one, name, 100, WITHIN) for name in ("power", "sinr"))
    x, y = grid(WITHIN)
    senders = [(0.0, 0.0), *zip(one.x[100].tolist(), one.y[100].tolist(), strict=True)]
    for row, column in ((11, 37), (40, 5), (60, 80)):
        place = x[row, column], y[row, column]
        best = max(decibels(one, sender, *place) for sender in senders)
        assert power[row, column] == pytest.approx(best, abs=1e-3)
        jamming = decibels(one, one.scenario.jammer.tolist(), *place)
        disturbance = 10 * np.log10(10 ** (one.settings.radio.noise_dbm / 10) + 10 ** (jamming / 10))
        assert sinr[row, column] == pytest.approx(best - disturbance, abs=1e-3)


def test_without_a_jammer_there_is_only_noise(episode):
    power, sinr = (field(episode, name, 5, WITHIN) for name in ("power", "sinr"))
    np.testing.assert_allclose(sinr, power - episode.settings.radio.noise_dbm, atol=1e-9)


def test_a_map_is_square_by_square_and_not_too_fine():
    x, y = grid(WITHIN)
    assert x.shape == y.shape
    assert 0.9 * MOST_PLACES < x.size <= MOST_PLACES
    across, up = x[0, 1] - x[0, 0], y[1, 0] - y[0, 0]
    assert across == pytest.approx(up, rel=0.05)
    assert (x[0, 0] - across / 2, y[-1, 0] + up / 2) == pytest.approx((-20, 60))
