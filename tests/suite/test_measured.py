"""Result files: written and read again, and refused by name when they are not what they should be."""

from __future__ import annotations

import dataclasses
import shutil

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.suite.measured import Measured, entries_in, find, load


def result(world, entry="mine", **changes) -> Measured:
    seeds = np.array(world.seeds_of("test"), np.int64)
    values = {
        "version": world.version, "world": world.name, "sha256": world.sha256, "entry": entry, "title": "Mine",
        "field": "yours", "digest": "0" * 64, "split": "test", "seeds": seeds,
        "delivered": np.tile(np.array([6, 3, 0], np.int32)[:, None], (2, 1, 2)),
        "steps": np.tile(np.array([60, 600, 600], np.int32)[:, None], (2, 1, 2)),
        "episodes": 5, "env_steps": 70,
    }  # fmt: skip
    return Measured(**(values | changes))


def test_it_is_read_as_it_was_written(tiny, tmp_path):
    world = tiny.worlds["few"]
    result(world).save(tmp_path)
    found = load(tmp_path, "mine", world)
    assert found.fitness(world)[0, :, 0] == pytest.approx([1 - 0.1, 0.5 - 1, -1])
    for field in dataclasses.fields(Measured):
        assert np.array_equal(getattr(found, field.name), getattr(result(world), field.name)), field.name
    assert entries_in(tmp_path) == ["mine"]
    assert load(tmp_path, "mine", tiny.worlds["open_short"]) is None


def test_equal_results_are_equal_bytes(tiny, tmp_path):
    for root in (tmp_path / "a", tmp_path / "b"):
        result(tiny.worlds["few"]).save(root)
    a, b = ((tmp_path / name / "results/mine/few.npz").read_bytes() for name in "ab")
    assert a == b


def test_the_first_folder_wins(tiny, tmp_path):
    world = tiny.worlds["few"]
    result(world, title="first").save(tmp_path / "a")
    result(world, title="second").save(tmp_path / "b")
    assert find("mine", world, [tmp_path / "none", tmp_path / "a", tmp_path / "b"]).title == "first"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sha256": "f" * 64}, "measured in other worlds"),
        ({"version": "suite-v2"}, "measured in other worlds"),
        ({"delivered": np.full((2, 3, 2), 7, np.int32)}, "delivered: a value beyond 0 to 6"),
        ({"steps": np.full((2, 3, 2), 601, np.int32)}, "steps: a value beyond 0 to 600"),
        ({"steps": np.zeros((2, 3, 1), np.int32)}, "steps is int32"),
        ({"seeds": np.array([1, 2, 3], np.int64)}, "seeds: others than the test seeds"),
        ({"seeds": np.zeros(2, np.int64)}, "seeds is int64"),
        ({"env_steps": -1}, "below 0"),
    ],
)
def test_what_it_cannot_be_is_one_line(tiny, tmp_path, changes, said):
    world = tiny.worlds["few"]
    result(world, **changes).save(tmp_path)
    with pytest.raises(InputError, match=said) as caught:
        load(tmp_path, "mine", world)
    assert "results/mine/few.npz" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("link", ["results", "results/mine", "results/mine/few.npz"])
def test_no_link_is_followed(tiny, tmp_path, link):
    world = tiny.worlds["few"]
    for name in ("outside", "root"):
        result(world).save(tmp_path / name)
    place = tmp_path / "root" / link
    shutil.rmtree(place) if place.is_dir() else place.unlink()
    place.symlink_to(tmp_path / "outside" / link)
    with pytest.raises(InputError, match=f"{place}.*is a link"):
        [load(tmp_path / "root", name, world) for name in entries_in(tmp_path / "root")]


def test_no_link_is_followed_to_nothing(tiny, tmp_path):
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "mine").symlink_to(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"results/mine.*is a link"):
        load(tmp_path, "mine", tiny.worlds["few"])


def test_what_is_no_folder_is_no_entry(tiny, tmp_path):
    result(tiny.worlds["few"]).save(tmp_path)
    (tmp_path / "results" / "notes.txt").write_text("x")
    assert entries_in(tmp_path) == ["mine"]
    (tmp_path / "validation").write_text("x")
    with pytest.raises(InputError, match="its folder validation is a file"):
        entries_in(tmp_path, "validation")


def test_damage_is_one_line(tiny, tmp_path):
    world = tiny.worlds["few"]
    result(world).save(tmp_path)
    path = tmp_path / "results/mine/few.npz"
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(InputError, match=r"few\.npz: .*delete it"):
        load(tmp_path, "mine", world)
