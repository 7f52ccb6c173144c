import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.policy import layers


@pytest.mark.parametrize("shape", [(5, 3), (3, 5), (4, 4)])
def test_orthogonal_weights_keep_lengths_on_the_shorter_side(shape):
    drawn = layers.orthogonal(np.random.default_rng(0), *shape, gain=2.0)
    assert drawn.shape == shape
    square = drawn.T @ drawn if shape[0] >= shape[1] else drawn @ drawn.T
    np.testing.assert_allclose(square, 4 * np.eye(min(shape)), atol=1e-5)


def test_a_layer_by_hand():
    one = {"w": np.array([[1.0], [2.0]], np.float32), "b": np.array([-1.0], np.float32)}
    network = {"dense": [one], "out": {"w": np.array([[3.0, 0.0]], np.float32), "b": np.array([0.0, 1.0], np.float32)}}
    carry, logits = layers.apply(network, jnp.zeros(0), jnp.array([0.5, 1.0]))
    np.testing.assert_allclose(logits, [3 * np.tanh(1.5), 1.0], rtol=1e-5)
    assert carry.shape == (0,)
    assert layers.memory(network) == 0


def test_a_gated_unit_by_hand():
    """One unit: input weights 1, 2, 3 and carry weights 0.5, -1, 2 for reset, update and candidate."""
    gru = {
        "input": np.array([[1.0, 2.0, 3.0]], np.float32),
        "carry": np.array([[0.5, -1.0, 2.0]], np.float32),
        "bias": np.array([0.1, 0.2, 0.3], np.float32),
    }
    dense = {"w": np.eye(1, dtype=np.float32), "b": np.zeros(1, np.float32)}
    network = {"dense": [dense], "gru": gru, "out": dense}
    before, given = 0.4, np.tanh(0.7)
    reset = 1 / (1 + np.exp(-(given + 0.1 + 0.5 * before)))
    update = 1 / (1 + np.exp(-(2 * given + 0.2 - before)))
    candidate = np.tanh(3 * given + 0.3 + reset * 2 * before)
    expected = (1 - update) * candidate + update * before
    carry, hidden = layers.forward(network, jnp.array([before], jnp.float32), jnp.array([0.7]))
    np.testing.assert_allclose([carry[0], hidden[0]], expected, rtol=1e-5)


@pytest.mark.parametrize("recurrent", [0, 4])
def test_unrolled_is_step_after_step(recurrent):
    rng = np.random.default_rng(0)
    network = layers.initial(rng, 3, 2, hidden=(5,), recurrent=recurrent)
    figures = rng.normal(size=(6, 7, 3)).astype(np.float32)
    start = rng.normal(size=(7, recurrent)).astype(np.float32)
    carry, expected = jnp.asarray(start), []
    for one in figures:
        carry, hidden = layers.forward(network, carry, jnp.asarray(one))
        expected.append(hidden)
    np.testing.assert_allclose(layers.unrolled(network, start, figures), np.stack(expected), rtol=1e-5, atol=1e-6)
    assert layers.memory(network) == recurrent
