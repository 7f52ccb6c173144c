"""A run's summary of its instances."""

from types import SimpleNamespace

import numpy as np
import pytest

from slcs2_jax.running.run import _instance_summary
from slcs2_jax.search import Deployment


def test_deployments_that_deliver_nothing_are_counted():
    none = np.zeros(2, np.int32)
    fresh = [Deployment(fitness=-1.0, delivered=0, steps=9, contribution=none)] * 3
    fresh += [Deployment(fitness=-0.9, delivered=1, steps=9, contribution=none)]  # little is not nothing
    instance = SimpleNamespace(
        measurement=SimpleNamespace(deployments=fresh),
        site=SimpleNamespace(seed=7),
        search=SimpleNamespace(generation=4),
        winner=SimpleNamespace(fitness=0.5),
        evaluations=5,
        env_steps=45,
    )
    summary = _instance_summary(instance)
    assert (summary.seed, summary.fresh_failed) == (7, 0.75)
    assert summary.fresh_mean == pytest.approx(-0.975)
