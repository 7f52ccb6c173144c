"""The checksum: the same for the last bit of a float, another for a millimetre."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.suite.frozen import canonical, digest
from slcs2_jax.suite.worlds import load_suite


@pytest.fixture(scope="module")
def scenario():
    return load_suite().worlds["two_patrols"].scenario(5_080_000)


def test_it_does_not_depend_on_the_last_bit(scenario):
    nudged = dataclasses.replace(scenario, start=np.nextafter(scenario.start, np.float32(np.inf)))
    assert canonical(nudged) == canonical(scenario)


@pytest.mark.parametrize("name", ["start", "sink", "sink_estimate"])
def test_a_millimetre_elsewhere_is_another_world(scenario, name):
    moved = dataclasses.replace(scenario, **{name: getattr(scenario, name) + np.float32(0.002)})
    assert canonical(moved) != canonical(scenario)


def test_jammers_and_walls_count(scenario):
    jammer, *others = scenario.jammers
    assert len(others) == 1
    for change in ({"speed": 3.0}, {"route": jammer.route + 1}, {"emission": "constant"}, {"place": jammer.place + 1}):
        other = dataclasses.replace(scenario, jammers=(dataclasses.replace(jammer, **change), *others))
        assert canonical(other) != canonical(scenario)
    wall = np.array([[1.0, 2.0, 3.0]], np.float32)
    there = canonical(dataclasses.replace(scenario, vertical=wall))
    assert there != canonical(dataclasses.replace(scenario, horizontal=wall))


def test_two_and_two_point_naught_are_one():
    assert digest({"a": 2, "b": None}, []) == digest({"b": None, "a": 2.0}, [])
    assert digest({"a": 2}, []) != digest({"a": True}, [])
