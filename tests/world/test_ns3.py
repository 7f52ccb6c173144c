"""The radio against ns-3: the same places, powers and loss models give the same received powers and SINR decisions.

ns-3 comes from its Python wheel, the extra `ns3`; without it this file is left out.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import Radio
from slcs2_jax.suite.worlds import load_suite
from slcs2_jax.world.radio import RadioParameters, decodable, received_power

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(importlib.util.find_spec("ns") is None, reason="the extra ns3 is not installed"),
]
PROGRAM = Path(__file__).with_name("ns3_powers.py")
SAID = Radio(fading="none")


@pytest.fixture(scope="module")
def both():
    """Received powers, mW [sender, receiver]: ours and ns-3's, between agents on their way, source and sink."""
    rng = np.random.default_rng(1)
    start = load_suite().worlds["urban_short"].scenario(5_020_000).start
    places = np.concatenate([start, rng.uniform([0, -100], [600, 100], (12, 2)), [[0, 0], [600, 0]]]).astype(np.float32)
    walls = np.triu(rng.integers(0, 6, (len(places), len(places))), 1)
    walls = walls + walls.T
    asked = {
        "places": places.astype(float).tolist(),
        "power_dbm": SAID.power_dbm,
        "exponent": SAID.path_loss_exponent,
        "reference_loss_db": SAID.reference_loss_db,
        "extra_db": (SAID.wall_loss_db * walls).tolist(),
    }
    done = subprocess.run([sys.executable, str(PROGRAM)], input=json.dumps(asked), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    theirs = np.array(json.loads(done.stdout)["mw"], np.float64)
    squared = ((places[:, None] - places) ** 2).sum(axis=-1)
    radio = RadioParameters.of(SAID)
    ours = received_power(jnp.asarray(squared), jnp.asarray(walls, jnp.float32), None, radio)
    return np.array(ours, np.float64), theirs


def test_received_powers_are_within_a_hundredth_of_a_decibel(both):
    ours, theirs = both
    pairs = ~np.eye(len(ours), dtype=bool)
    difference = 10 * np.log10(ours[pairs] / theirs[pairs])
    assert len(difference) == 26 * 25
    assert np.abs(difference).max() < 0.01


def test_sinr_decisions_are_the_same(both):
    """One sender, none to three others at once, one receiver: thousands of cases, decided on both sides of it."""
    count = len(both[0])
    rng, radio = np.random.default_rng(2), RadioParameters.of(SAID)
    noise, sensitivity, threshold = (
        10 ** (level / 10) for level in (SAID.noise_dbm, SAID.receive_threshold_dbm, SAID.sinr_threshold_db)
    )
    cases = [rng.permutation(count)[: rng.integers(2, 6)] for _ in range(5000)]  # receiver, sender, others
    signal = np.array([[powers[case[1], case[0]] for case in cases] for powers in both])
    others = np.array([[powers[case[2:], case[0]].sum() for case in cases] for powers in both])
    expected = (signal[1] >= sensitivity) & (signal[1] / (noise + others[1]) >= threshold)
    found = decodable(jnp.asarray(signal[0], jnp.float32), jnp.asarray(others[0], jnp.float32), radio)
    np.testing.assert_array_equal(np.asarray(found), expected)
    assert 500 < expected.sum() < 4500
