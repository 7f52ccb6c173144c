"""Radio maps against the simulator's own radio."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.analysis.radio_map import MOST_PLACES, field, grid, received_dbm, walls_between
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.geometry import count_crossings
from slcs2_jax.world.radio import RadioParameters, received_power

WITHIN = (-20.0, 130.0, -60.0, 60.0)


def places(count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return rng.uniform(-20, 130, count), rng.uniform(-60, 60, count)


def test_power_is_what_the_simulator_computes_without_shadowing(jammed_episode):
    one, (x, y) = jammed_episode, places()
    sender = np.float32(7.0), np.float32(-3.0)
    arena = stack([one.scenario] * len(x), [one.channels] * len(x), capacity=wall_capacity([one.scenario]), width=1)
    ends = [jnp.asarray(np.broadcast_to(np.asarray(value, np.float32), x.shape)) for value in (*sender, x, y)]
    walls = count_crossings(*ends, arena.walls)
    np.testing.assert_array_equal(walls_between(one.scenario, (7.0, -3.0), x, y), np.asarray(walls))
    assert len(np.unique(walls)) > 3
    squared = (ends[0] - ends[2]) ** 2 + (ends[1] - ends[3]) ** 2
    power = received_power(squared, walls, jnp.zeros_like(walls), RadioParameters.of(one.settings.radio))
    mine = received_dbm(one.settings.radio, one.scenario, (7.0, -3.0), x, y)
    np.testing.assert_allclose(mine, 10 * np.log10(np.asarray(power, np.float64)), atol=1e-3)


def test_the_strongest_sender_counts_and_the_jammer_disturbs(jammed_episode):
    one = jammed_episode
    radio, noise = one.settings.radio, 10 ** (one.settings.radio.noise_dbm / 10)
    power, sinr = (field(one, name, 100, WITHIN) for name in ("power", "sinr"))
    x, y = grid(WITHIN)
    senders = [(0.0, 0.0), *zip(one.x[100].tolist(), one.y[100].tolist(), strict=True)]
    row, column = 11, 37
    best = max(
        received_dbm(radio, one.scenario, sender, x[row, column, None], y[row, column, None])[0] for sender in senders
    )
    assert power[row, column] == pytest.approx(best)
    jammer = tuple(one.scenario.jammer.tolist())
    disturbance = 10 ** (received_dbm(radio, one.scenario, jammer, x[row, column, None], y[row, column, None])[0] / 10)
    assert sinr[row, column] == pytest.approx(best - 10 * np.log10(noise + disturbance))


def test_without_a_jammer_there_is_only_noise(episode):
    power, sinr = (field(episode, name, 5, WITHIN) for name in ("power", "sinr"))
    np.testing.assert_allclose(sinr, power - episode.settings.radio.noise_dbm)


def test_a_map_is_square_by_square_and_not_too_fine():
    x, y = grid(WITHIN)
    assert x.shape == y.shape
    assert 0.9 * MOST_PLACES < x.size <= MOST_PLACES
    across, up = x[0, 1] - x[0, 0], y[1, 0] - y[0, 0]
    assert across == pytest.approx(up, rel=0.05)
    assert (x[0, 0] - across / 2, y[-1, 0] + up / 2) == pytest.approx((-20, 60))
