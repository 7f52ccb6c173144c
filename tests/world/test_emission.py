"""When and where jammers transmit: worked cases."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.world import emission, randomness
from slcs2_jax.world.emission import Listening, in_use


def listening(t=0, *, hears=(True,), channels=(True,), duty=0.5, dwell=10):
    jammers = len(hears)
    number = np.arange(jammers, dtype=np.int32)

    def words(time):
        stream = randomness.stream(jnp.array([1, 2], jnp.uint32), time, randomness.Purpose.EMISSION)
        return randomness.bits(stream, number.astype(np.uint32))

    return Listening(
        t=jnp.int32(t),
        number=number,
        hears=jnp.array(hears),
        channels=jnp.array(channels),
        duty=jnp.full(jammers, duty, jnp.float32),
        dwell=jnp.full(jammers, dwell, jnp.int32),
        words=words,
    )


@pytest.mark.parametrize(
    ("channels", "numbers", "found"),
    [
        ((True, True, True), [0, 1, 2, 3, 7], [0, 1, 2, 0, 1]),
        ((False, True, False, True), [0, 1, 2, 3, 4], [1, 3, 1, 3, 1]),
        ((False, False, True), [0, 5, 6, 7, 8], [2] * 5),
    ],
)
def test_channels_in_use_are_counted_round_and_round(channels, numbers, found):
    assert in_use(jnp.array(channels), jnp.array(numbers, jnp.int32)).tolist() == found


def test_a_reactive_one_answers_on_the_first_channel_in_use():
    heard = listening(hears=(True, False), channels=(False, True, True))
    assert emission.reactive(heard).tolist() == [1, -1]


def test_a_constant_one_always_transmits():
    assert emission.constant(listening(hears=(False, True), channels=(False, True))).tolist() == [1, 1]


def test_a_sweeping_one_dwells_on_each_channel_in_use():
    found = [int(emission.sweeping(listening(t, channels=(True, False, True), dwell=3))[0]) for t in range(12)]
    assert found == [0, 0, 0, 2, 2, 2, 0, 0, 0, 2, 2, 2]


def test_several_sweep_side_by_side():
    found = emission.sweeping(listening(0, hears=(True,) * 3, channels=(True,) * 3))
    assert found.tolist() == [0, 1, 2]


@pytest.mark.parametrize("duty", [0.0, 0.3, 1.0])
def test_a_random_one_transmits_its_share_of_the_intervals_on_all_channels_alike(duty):
    many = listening(0, hears=(True,) * 20_000, channels=(True, False, True, True), duty=duty, dwell=5)
    found = np.asarray(emission.random(many))
    assert np.mean(found >= 0) == pytest.approx(duty, abs=4 * 0.5 / np.sqrt(20_000))
    on = found[found >= 0]
    if duty:
        shares = np.bincount(on, minlength=4) / len(on)
        np.testing.assert_allclose(shares, [1 / 3, 0, 1 / 3, 1 / 3], atol=0.03)


def test_a_random_one_changes_only_from_interval_to_interval():
    found = np.array([np.asarray(emission.random(listening(t, hears=(True,) * 50, dwell=4))) for t in range(16)])
    for interval in range(4):
        assert (found[4 * interval : 4 * interval + 4] == found[4 * interval]).all()
    assert len({tuple(row) for row in found}) == 4
