"""The least time, on cases that can be done by hand; and that nobody is better."""

from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.suite.bound import best_fitness, least_time

STARTS = np.array([[0.0, 50.0], [40.0, 0.0]])


@pytest.mark.parametrize(
    ("packets", "net", "channels", "expected"),
    [
        (1, 160.0, 3, 200 + 2),  # the nearer one walks 400 m at 2 m a step, collects and sends
        (1, 560.0, 3, 2),  # it hears the sink where it starts
        (4, 560.0, 3, 2 + 3),  # two agents hand over one packet a step
        (4, 560.0, 1, 2 + 3),
    ],
)
def test_by_hand(packets, net, channels, expected):
    sink = np.array([600.0, 0.0])
    assert least_time(STARTS, sink, packets=packets, speed=2.0, net=net, channels=channels) == expected


def test_many_agents_are_held_up_by_the_sinks_channels():
    starts = np.array([[10.0 * k, 0.0] for k in range(12)])
    found = least_time(starts, np.array([200.0, 0.0]), packets=31, speed=2.0, net=163.0, channels=3)
    assert found == 2 + 10


def test_of_a_world_it_is_a_fitness_for_each_test_world(tiny):
    found = best_fitness(tiny.worlds["few"])
    assert found.shape == (3,)
    assert ((found > 0.9) & (found < 1)).all()
