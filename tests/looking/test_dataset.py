"""A recording as a Dataset: every array of it, named, with units."""

import dataclasses

import numpy as np
import pytest

from slcs2_jax.looking.dataset import VARIABLES

pytest.importorskip("xarray")


def test_every_array_is_there(jammed_episode):
    data = jammed_episode.to_xarray()
    arrays = {
        field.name
        for field in dataclasses.fields(jammed_episode)
        if isinstance(getattr(jammed_episode, field.name), np.ndarray)
    }
    assert set(data.data_vars) == arrays == {*VARIABLES, "heard"}
    for name in VARIABLES:
        np.testing.assert_array_equal(data[name], getattr(jammed_episode, name))
        assert data[name].attrs["description"]
    assert data.x.attrs["units"] == "m"
    assert data.sizes["moment"] == data.sizes["step"] + 1 == jammed_episode.steps + 1
    np.testing.assert_array_equal(data.heard[5], jammed_episode.neighbours(5))
    assert data.node.values[-2:].tolist() == ["source", "sink"]
    assert data.channel.values.tolist() == [1]
    assert data.attrs["fitness"] == jammed_episode.fitness
