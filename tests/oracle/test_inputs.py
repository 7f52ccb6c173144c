"""What the oracle takes, and refuses."""

import numpy as np
import pytest

from slcs2_jax.config import InputError, Learning, Radio, Swarm
from tests.oracle import inputs


def test_params_are_in_the_units_of_the_formulas():
    params = inputs.make_params(Radio(), Swarm(), Learning(alpha_q_final=0.05), wall_thickness=2.0)
    assert params.noise == pytest.approx(10**-9.4)
    assert params.receive == pytest.approx(np.exp(params.log_receive))
    assert params.sinr == pytest.approx(10.0)
    assert params.half_power == pytest.approx(0.5, abs=1e-4)
    assert params.half_thickness == 1.0
    assert params.alpha_q_final == 0.05
    assert inputs.make_params(Radio(), Swarm(), Learning()).alpha_q_final == 0.15


def test_walls_are_sorted():
    walls = inputs.make_walls([(5, 0, 1), (-2, 3, 4)])
    assert walls.line.tolist() == [-2, 5]
    assert walls.low.tolist() == [3, 0]


def world(**changes):
    return inputs.make_world(**({"start": [(0, 0), (5, 5)], "sink": (100, 0), "time_limit": 9} | changes))


def test_a_world_without_jammer_or_estimate():
    made = world()
    assert not made.has_jammer
    assert made.sink_estimate.tolist() == [100, 0]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("start", [(0, 0)]),
        ("start", [(0, 0, 0), (1, 1, 1)]),
        ("start", [(0, 0), (np.nan, 0)]),
        ("sink", 5.0),
        ("jammer", (1, 2, 3)),
        ("sink_estimate", (np.inf, 0)),
        ("time_limit", 0),
        ("vertical", [(1, 3, 2)]),
        ("horizontal", [(np.nan, 3, 2)]),
    ],
)
def test_bad_worlds_are_refused(field, value):
    with pytest.raises(InputError, match="accepted"):
        world(**{field: value})


@pytest.mark.parametrize(
    ("mask", "action", "channels"),
    [
        ((2, 5, 3), (2, 5), (1, 0, 0)),
        ((2, 5, 4), (2, 4), (1, 0, 0)),
        ((2, 5, 4), (2, 5), (0, 0, 0)),
        ((2, 5, 4), (2, 5), (1, 1)),
    ],
)
def test_bad_rules_are_refused(mask, action, channels):
    with pytest.raises(InputError, match="accepted"):
        inputs.make_rules(np.zeros(mask, np.uint32), np.zeros(action), channels)
