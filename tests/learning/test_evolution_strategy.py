import json

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax.config import InputError
from slcs2_jax.learning import evolution_strategy as learning
from tests.learning.tiny import FRESH, SETTINGS, TRAINED, strategy


def test_ranks_go_from_minus_a_half_to_a_half_and_equal_ones_share_theirs():
    found = learning.ranked(np.array([[5.0, -1.0], [-1.0, 1e9]]))
    np.testing.assert_allclose(found, [[2 / 3 - 0.5, 0.5 / 3 - 0.5], [0.5 / 3 - 0.5, 0.5]])
    assert not learning.ranked(np.full((2, 3), -1.0)).any()  # nothing is to be learnt where all are alike


def test_the_gradient_by_hand():
    """Two pairs: of the first the network with the noise is the best, of the second that against it."""
    noise = np.array([[1.0, 2.0], [0.0, 4.0]], np.float32)
    fitness = np.array([[0.9, 0.1], [0.2, 0.8]])
    # ranks 0.5, -0.5 and -1/6, 1/6: differences 2/3 and -2/3, over 2 pairs x 2 x sigma
    expected = (2 / 3 * noise[0] - 2 / 3 * noise[1]) / (2 * 2 * 0.1)
    np.testing.assert_allclose(learning.gradient(noise, fitness, 0.1), expected, rtol=1e-6)


def test_a_training_that_was_stopped_goes_on_to_the_same_bytes(tmp_path):
    for folder, budgets in (("whole", [5000]), ("parts", [1, 5000])):
        for budget in budgets:
            learning.train(strategy(), TRAINED, seed=1, budget_env_steps=budget, folder=tmp_path / folder)
    for name in ("curve.jsonl", "checkpoint.npz", "policy.npz"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes()
    curve = [json.loads(line) for line in (tmp_path / "whole" / "curve.jsonl").read_text().splitlines()]
    assert [line["generation"] for line in curve] == list(range(1, len(curve) + 1))
    assert len(curve) > 1


@pytest.mark.slow
def test_it_learns_to_deliver_sooner():
    settings = strategy()
    start = settings.network.start(SETTINGS, 0)
    trained = learning.train(settings, TRAINED, seed=0, budget_env_steps=60_000)
    before, after = slcs2.Evaluator(SETTINGS)([start, trained], FRESH).mean
    assert after > before + 0.3


def test_pairs_are_needed():
    with pytest.raises(InputError, match=r"^strategy.population=7: accepted is an even number$"):
        strategy(population=7)
