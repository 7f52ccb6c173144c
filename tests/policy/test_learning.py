"""Parameters of learning and the schedule of the learning rate."""

from __future__ import annotations

import jax.numpy as jnp
import pytest

from slcs2_jax.config import Learning
from slcs2_jax.policy.learning import LearningParameters


def alpha(share, **learning):
    return LearningParameters.of(Learning(**learning)).alpha(jnp.float32(share))


def test_values_are_those_of_the_settings():
    got = LearningParameters.of(Learning(alpha_grasp=0.3, beta_q=0.5, trace_decay=0.7, bp_max=5))
    assert float(got.alpha_grasp) == pytest.approx(0.3)
    assert float(got.beta_q) == pytest.approx(0.5)
    assert float(got.trace_decay) == pytest.approx(0.7)
    assert got.bp_max == 5


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_rate_is_constant_without_a_final_value(share):
    assert float(alpha(share)) == pytest.approx(0.15)


@pytest.mark.parametrize(("share", "expected"), [(0, 0.5), (0.25, 0.4), (0.5, 0.3), (1, 0.1)])
def test_the_rate_changes_linearly_to_its_final_value(share, expected):
    assert float(alpha(share, alpha_q=0.5, alpha_q_final=0.1)) == pytest.approx(expected)


def test_the_rate_may_end_at_0_and_may_grow():
    assert float(alpha(1.0, alpha_q_final=0.0)) == 0
    assert float(alpha(0.5, alpha_q=0.1, alpha_q_final=0.3)) == pytest.approx(0.2)


def test_each_instance_has_its_own_share():
    rates = LearningParameters.of(Learning(alpha_q=0.5, alpha_q_final=0.1)).alpha(jnp.array([0.0, 0.5, 1.0]))
    assert rates.tolist() == pytest.approx([0.5, 0.3, 0.1])
