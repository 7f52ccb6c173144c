"""What a training leaves goes on from, whole; what is damaged, or a stranger's, is refused in a line that names it."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config.errors import StorageError
from slcs2_jax.learning.training_folder import CHECKPOINT, CURVE, FORMAT, TrainingFolder
from slcs2_jax.results.archive import read_archive, write_archive
from slcs2_jax.results.rows import row_line

IDENTITY = {"algorithm": "ippo", "seed": 1}
TREE = {"weights": np.arange(6, dtype=np.float32).reshape(2, 3), "steps": np.zeros(4, np.int32)}
COUNTERS = {"env_steps": 3, "playing": [0, 1, 2]}


def save(path, rows=3) -> None:
    path.mkdir(exist_ok=True)
    folder = TrainingFolder(path, IDENTITY)
    for number in range(rows):
        folder.note({"env_steps": 1 + number, "loss": 0.5 / (1 + number)})
    folder.save(TREE, COUNTERS)


def load(path):
    return TrainingFolder(path, IDENTITY).load(TREE, {"env_steps": 0, "playing": [0, 0, 0]})


def again(path, arrays=None, **about) -> None:
    """The checkpoint once more, with something else in it."""
    found, said = read_archive(path / CHECKPOINT, FORMAT)
    write_archive(path / CHECKPOINT, FORMAT, found | (arrays or {}), said | about)


def test_it_is_read_as_it_was_written(tmp_path):
    save(tmp_path)
    folder = TrainingFolder(tmp_path, IDENTITY)
    tree, counters = folder.load(TREE, COUNTERS)
    np.testing.assert_array_equal(tree["weights"], TREE["weights"])
    assert counters == COUNTERS
    assert [row["loss"] for row in folder.last(2)] == [0.25, 0.5 / 3]
    before = (tmp_path / CURVE).read_bytes()
    folder.save(tree, counters)
    assert (tmp_path / CURVE).read_bytes() == before


def test_what_was_noted_after_the_last_save_is_forgotten(tmp_path):
    save(tmp_path)
    with (tmp_path / CURVE).open("ab") as file:
        file.write(b'{"env_steps": 4, "lo')
    folder = TrainingFolder(tmp_path, IDENTITY)
    folder.load(TREE, COUNTERS)
    assert len(folder.last(9)) == 3


def test_no_folder_and_no_checkpoint_are_nothing(tmp_path):
    assert load(None) is None
    assert load(tmp_path) is None


@pytest.mark.parametrize(
    ("about", "said"),
    [
        (
            {"identity": {"algorithm": "ippo", "seed": 2}},
            r"is of another training \(seed differ\); accepted is another folder",
        ),
        ({"identity": [1]}, "its description is not that of a training"),
        ({"counters": [1]}, "its counters are not those of this training"),
        ({"counters": {"env_steps": 3}}, "its counters are not those of this training"),
        ({"counters": {"env_steps": -1, "playing": [0, 0, 0]}}, "env_steps=-1: accepted is a whole number"),
        ({"counters": {"env_steps": 10**30, "playing": [0, 0, 0]}}, "env_steps=10"),
        ({"counters": {"env_steps": [1], "playing": [0, 0, 0]}}, "accepted is a whole number"),
        ({"counters": {"env_steps": 1, "playing": [0, 0]}}, "playing is no list of 3 counts"),
        ({"counters": {"env_steps": 1, "playing": 3}}, "playing is no list of 3 counts"),
        ({"counters": {"env_steps": 1, "playing": [0, 0, "1"]}}, "playing=1: accepted is a whole number"),
        ({"lines": "3"}, "lines=3: accepted is a whole number"),
        ({"lines": 10**9}, "lines=1000000000: accepted is a whole number"),
    ],
)
def test_an_odd_description_is_one_line(tmp_path, about, said):
    save(tmp_path)
    again(tmp_path, **about)
    with pytest.raises(InputError, match=said) as caught:
        load(tmp_path)
    assert str(tmp_path / CHECKPOINT) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.zeros((2, 4), np.float32), r"leaf_1 is float32\[2, 4\]"),
        (np.zeros((2, 3), np.float64), r"leaf_1 is float64\[2, 3\]"),
        (np.zeros(2**24, np.float32), "leaf_1.npy is too large"),  # before anything of it is unpacked
    ],
)
def test_arrays_of_another_training_are_one_line(tmp_path, array, said):
    save(tmp_path)
    again(tmp_path, {"leaf_1": array})
    with pytest.raises(InputError, match=said) as caught:
        load(tmp_path)
    assert str(tmp_path / CHECKPOINT) in str(caught.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data.replace(b"0.25", b"0.26"), "its checksum does not fit"),
        (lambda data: data[:-5], "no JSON, or cut short"),
        (lambda data: data[: data.index(b"\n") + 1], "has not the 3 whole lines"),
        (lambda data: data[:-1], "has not the 3 whole lines"),
        (lambda data: data[: data.index(b"\n") + 1] + data, "has not the 3 whole lines"),  # one is there twice
        (
            lambda data: b"".join(data.splitlines(keepends=True)[place] for place in (1, 0, 2)),
            "has not the 3 whole lines",
        ),
        (lambda data: data[data.index(b"\n") + 1 :] + row_line({"env_steps": 4}), "has not the 3 whole lines"),
        (lambda data: row_line({"loss": 0.5}) + data, "env_steps=null: accepted is a whole number"),
        (lambda data: b"[" * 1000 + b"\n" + data, "line|JSON"),
        (lambda data: b"x" * 5000 + data, "line 1: longer than 4096 bytes"),
    ],
)
def test_a_damaged_curve_is_one_line(tmp_path, change, said):
    save(tmp_path)
    (tmp_path / CURVE).write_bytes(change((tmp_path / CURVE).read_bytes()))
    with pytest.raises(InputError, match=said) as caught:
        load(tmp_path)
    assert str(tmp_path / CURVE) in str(caught.value)


@pytest.mark.parametrize("name", [CURVE, CHECKPOINT])
def test_a_link_is_not_read(tmp_path, name):
    save(tmp_path / "other")
    save(tmp_path / "mine")
    (tmp_path / "mine" / name).unlink()
    (tmp_path / "mine" / name).symlink_to(tmp_path / "other" / name)
    with pytest.raises(InputError, match=f"{name}: .*is a link") as caught:
        load(tmp_path / "mine")
    assert "mine" in str(caught.value)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_is_named(tmp_path):
    save(tmp_path)
    (tmp_path / CURVE).chmod(0)
    with pytest.raises(StorageError, match=CURVE):
        load(tmp_path)


def test_the_curve_is_rows_with_checksums(tmp_path):
    save(tmp_path, 1)
    line = (tmp_path / CURVE).read_bytes()
    assert line == row_line({"env_steps": 1, "loss": 0.5})
    assert set(json.loads(line)) == {"env_steps", "loss", "crc"}
