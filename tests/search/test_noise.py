"""The noise within solutions."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from slcs2_jax.search import Noise


def test_it_is_the_pooled_deviation_of_what_was_deployed_more_than_once():
    noise, rng = Noise(), np.random.default_rng(0)
    for _ in range(2000):
        noise.add((rng.normal(rng.normal(0, 10), 0.3, 3)).tolist())  # how solutions differ does not matter
        noise.add([5.0])
    assert noise.deviation == pytest.approx(0.3, abs=0.01)
    assert noise.error(9) == noise.deviation / 3


def test_before_anything_is_measured_it_is_a_guess_that_weighs_little():
    noise = Noise()
    assert noise.deviation == pytest.approx(0.15)
    noise.add([0.0] * 30)
    assert noise.deviation == pytest.approx(0.15 * math.sqrt(2 / 31))


def test_it_goes_on_exactly():
    noise, again = Noise(), Noise()
    noise.add([0.1, 0.7, 0.3])
    again.restore(json.loads(json.dumps(noise.state())))
    for one in (noise, again):
        one.add([0.2, 0.9])
    assert again.deviation == noise.deviation
