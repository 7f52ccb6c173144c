"""Policies in files: what goes in comes out, and what is none is refused in one line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slcs2_jax.config import InputError
from slcs2_jax.results import policy_file
from slcs2_jax.results.archive import Limits, write_archive
from slcs2_jax.results.policy_file import FORMAT, load_policy, save_policy

LAYERS = {"layers": [(np.ones((2, 3), np.float32), np.zeros(3, np.int32)), (np.eye(3), np.array(True))], "scale": 2.5}


def test_what_is_saved_comes_back(tmp_path):
    save_policy(tmp_path / "p.npz", "mine", LAYERS, {"trained": 7})
    found = load_policy(tmp_path / "p.npz")
    assert (found.name, found.about) == ("mine", {"trained": 7})
    assert isinstance(found.given["layers"], list)
    assert isinstance(found.given["layers"][0], tuple)
    for one, other in zip(found.given["layers"], LAYERS["layers"], strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
    assert found.given["scale"] == 2.5


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({1: np.ones(2)}, "a key that is no text"),
        ({"a": "text"}, "accepted are dictionaries, lists, tuples and arrays"),
        ({"a": lambda: 1}, "accepted are dictionaries, lists, tuples and arrays"),
        ({"a": np.array([np.nan])}, "not finite"),
    ],
)
def test_other_parameters_are_refused(tmp_path, given, said):
    with pytest.raises(InputError, match=said):
        save_policy(tmp_path / "p.npz", "mine", given)
    assert not (tmp_path / "p.npz").exists()


def test_what_could_not_be_read_again_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(policy_file, "_LIMITS", Limits(entries=9, size=99))
    save_policy(tmp_path / "p.npz", "mine", np.zeros(12))
    assert load_policy(tmp_path / "p.npz").given.shape == (12,)
    with pytest.raises(InputError, match="parameters: 104 bytes in 1 arrays; accepted are at most 99 bytes"):
        save_policy(tmp_path / "q.npz", "mine", np.zeros(13))
    assert not (tmp_path / "q.npz").exists()


@pytest.mark.parametrize(
    "about",
    [
        {"policy": "mine", "tree": "leaf_9", "about": {}},
        {"policy": "mine", "tree": {"set": []}, "about": {}},
        {"policy": "", "tree": "leaf_0", "about": {}},
        {"policy": "mine", "tree": "leaf_0"},
        {"policy": "mine", "tree": {"list": ["leaf_0", {"dict": 3}]}, "about": {}},
        {"policy": "mine", "tree": {"list": ["leaf_0", "leaf_0"]}, "about": {}},  # gigabytes, were it there often
        {"policy": "mine", "tree": {"list": []}, "about": {}},
    ],
)
def test_a_file_that_is_none_is_refused_by_name(tmp_path, about):
    write_archive(tmp_path / "p.npz", FORMAT, {"leaf_0": np.ones(2)}, about)
    with pytest.raises(InputError, match=r"policy=.*p\.npz: not a policy saved by slcs2"):
        load_policy(tmp_path / "p.npz")


def test_a_solution_is_no_policy(tmp_path):
    write_archive(tmp_path / "p.npz", "slcs2_jax solution 3", {}, {})
    with pytest.raises(InputError, match="accepted is 'slcs2_jax policy 1'"):
        load_policy(tmp_path / "p.npz")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("policies") / "whole.npz"
    save_policy(path, "mine", LAYERS, {"trained": 7})
    return path.read_bytes()


@given(cut=st.floats(0, 1), changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(1, 255))))
def test_a_damaged_file_is_refused_or_its_damage_is_harmless(whole, tmp_path_factory, cut, changes):
    data = bytearray(whole[: round(cut * len(whole))] if not changes else whole)
    for place, flip in changes:
        data[int(place * len(data))] ^= flip
    path = tmp_path_factory.mktemp("damaged") / "p.npz"
    path.write_bytes(data)
    try:
        found = load_policy(path)
    except InputError as error:
        told = str(error)
    else:
        np.testing.assert_array_equal(found.given["layers"][0][0], LAYERS["layers"][0][0])
        told = f"policy={path}: {found.name}"
    assert told.startswith(f"policy={path}: ")
    assert "\n" not in told
