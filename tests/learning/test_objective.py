import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.learning import objective


@pytest.mark.parametrize(
    ("ratio", "advantage", "expected"),
    [
        (1.1, 2.0, 2.2),  # within the clip
        (1.5, 2.0, 2.4),  # no more than 1.2 of it counts
        (0.5, 2.0, 1.0),  # a good action became rarer: all of that counts
        (0.5, -2.0, -1.6),  # a bad one became rarer: down to 0.8 counts
        (1.5, -2.0, -3.0),  # a bad one became likelier: all of that counts
    ],
)
def test_the_clipped_objective_by_hand(ratio, advantage, expected):
    found = objective.clipped(jnp.float32(ratio), jnp.float32(advantage), 0.2)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_nothing_is_to_be_gained_beyond_the_clip():
    slope = jax.grad(lambda ratio: objective.clipped(ratio, jnp.float32(1), 0.2))
    assert slope(jnp.float32(1.1)) == 1
    assert slope(jnp.float32(1.3)) == 0


def test_probabilities_and_entropy_are_of_the_actions_that_are_not_masked():
    logits, mask = jnp.log(jnp.array([[1.0, 3.0, 100.0]])), jnp.array([[True, True, False]])
    likely = objective.log_probabilities(logits, mask)
    np.testing.assert_allclose(likely, [[np.log(0.25), np.log(0.75), 0]], rtol=1e-5)
    expected = -(0.25 * np.log(0.25) + 0.75 * np.log(0.75))
    np.testing.assert_allclose(objective.entropy(likely, mask), [expected], rtol=1e-5)
    slope = jax.grad(lambda logits: objective.entropy(objective.log_probabilities(logits, mask), mask).sum())(logits)
    assert np.isfinite(slope).all()
    assert slope[0, 2] == 0


def test_a_mean_is_of_the_samples_that_count():
    assert objective.mean(jnp.array([1.0, 3.0, 1e9]), jnp.array([1.0, 1.0, 0.0])) == 2
    assert objective.mean(jnp.array([5.0]), jnp.zeros(1)) == 0
