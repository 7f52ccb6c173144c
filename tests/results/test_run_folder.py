"""The run folder: what it holds, and that nothing in it is overwritten or damaged silently."""

import json

import pytest

from slcs2_jax.config import InputError, Settings
from slcs2_jax.results import RunFolder, check_free, read_run


def settings(path) -> Settings:
    return Settings(run_dir=str(path), seed=3)


def test_write_and_read(tmp_path):
    folder = RunFolder.create(settings(tmp_path / "a" / "run"), device="2 x cpu")
    folder.append([{"generation": 0, "instance": 0, "best": 0.5}, {"generation": 0, "instance": 1, "best": -1.0}])
    folder.append([{"generation": 1, "instance": 0, "best": 0.6}])
    assert read_run(folder.path).summary is None
    folder.write_summary({"wall_seconds": 1.5})
    run = read_run(folder.path)
    assert run.settings == settings(folder.path)
    assert [row["best"] for row in run.rows] == [0.5, -1.0, 0.6]
    assert run.summary == {"wall_seconds": 1.5}
    assert run.timing is None
    assert run.record["device"] == "2 x cpu"
    assert {"slcs2_jax", "jax", "numpy", "python"} <= set(run.record["versions"])


def test_a_second_run_is_refused_and_the_first_stays(tmp_path):
    folder = RunFolder.create(settings(tmp_path), device="cpu")
    before = (folder.path / "config.yaml").read_bytes()
    with pytest.raises(InputError, match=r"already holds a run \(config.yaml\)"):
        RunFolder.create(settings(tmp_path), device="cpu")
    assert (folder.path / "config.yaml").read_bytes() == before


def test_a_folder_with_other_files_will_do(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert check_free(tmp_path) == tmp_path
    RunFolder.create(settings(tmp_path), device="cpu")
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("below", ["", "deeper/still"])
def test_a_file_in_the_way(tmp_path, below):
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="is a file; accepted is a folder"):
        check_free(tmp_path / "file" / below)


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_no_nan_enters_a_file(tmp_path, bad):
    folder = RunFolder.create(settings(tmp_path), device="cpu")
    folder.append([{"best": 1.0}])
    with pytest.raises(ValueError, match="not JSON compliant"):
        folder.append([{"best": 2.0}, {"best": bad}])
    with pytest.raises(ValueError, match="not JSON compliant"):
        folder.write_summary({"best": bad})
    assert len(read_run(tmp_path).rows) == 1
    assert not (tmp_path / "summary.json").exists()


def test_a_row_cut_short_is_left_out_and_a_damaged_one_is_named(tmp_path):
    folder = RunFolder.create(settings(tmp_path), device="cpu")
    folder.append([{"best": 1.0}])
    with (tmp_path / "generations.jsonl").open("a") as file:
        file.write('{"best": 2')
    assert [row["best"] for row in read_run(tmp_path).rows] == [1.0]
    (tmp_path / "generations.jsonl").write_text('{"best": NaN}\n')
    with pytest.raises(InputError, match=r"generations.jsonl: line 1: no JSON.*NaN"):
        read_run(tmp_path)


def test_no_run_folder(tmp_path):
    with pytest.raises(InputError, match=r"config.yaml: not the configuration of a run of slcs2"):
        read_run(tmp_path)


def test_summary_is_plain_json(tmp_path):
    folder = RunFolder.create(settings(tmp_path), device="cpu")
    folder.write_summary({"instances": [{"seed": 1}]})
    document = json.loads((tmp_path / "summary.json").read_text())
    assert document.pop("checksum")
    assert document == {"format": "slcs2_jax summary 1", "instances": [{"seed": 1}]}
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []
