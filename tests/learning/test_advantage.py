import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.learning.advantage import Scale, advantages

GAMMA, LAMBDA = 0.5, 0.5


def estimated(reward, value, terminated, over):
    arrays = (jnp.array(reward, jnp.float32), jnp.array(value, jnp.float32), jnp.array(terminated), jnp.array(over))
    return advantages(*arrays, discount=GAMMA, decay=LAMBDA)


@pytest.mark.parametrize(
    ("terminated", "over", "expected"),
    [
        # deltas 1 + 0.5 * 4 - 2 = 1, 2 + 0.5 * 6 - 4 = 1, 3 + 0.5 * 8 - 6 = 1
        ([False, False, False], [False, False, False], [1 + 0.25 * (1 + 0.25), 1 + 0.25, 1]),
        # the task is done with the second step: 2 - 4 = -2, and nothing of what comes after counts
        ([False, True, False], [False, True, True], [1 + 0.25 * -2, -2, 1]),
        # time is up with the second step: what would have come is worth 6
        ([False, False, False], [False, True, True], [1 + 0.25 * 1, 1, 1]),
    ],
)
def test_by_hand(terminated, over, expected):
    found = estimated([1.0, 2.0, 3.0], [2.0, 4.0, 6.0, 8.0], terminated, over)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_agents_do_not_mix():
    found = estimated([[1.0, 0.0]], [[2.0, 0.0], [4.0, 0.0]], [[False, True]], [[False, True]])
    np.testing.assert_allclose(found, [[1.0, 0.0]])


def test_returns_are_scaled_by_their_own_running_moments():
    weight = jnp.array([1.0, 1.0, 0.0])
    scale = Scale.new()
    assert [float(one) for one in scale.moments] == [0, 1]
    once = scale.seen(jnp.array([1.0, 3.0, 1e6]), weight, 0.9)
    np.testing.assert_allclose(once.moments, [2, 1], rtol=1e-4)  # the moments themselves, however little was seen
    twice = once.seen(jnp.array([5.0, 5.0, 0.0]), weight, 0.9)
    mean = (0.09 * 2 + 0.1 * 5) / 0.19
    square = (0.09 * 5 + 0.1 * 25) / 0.19
    np.testing.assert_allclose(twice.moments, [mean, np.sqrt(square - mean**2)], rtol=1e-4)
    value = jnp.array([0.5, -1.0])
    np.testing.assert_allclose(twice.scaled(twice.real(value)), value, rtol=1e-4)
