"""A sweep's note names folders below its own, and nothing else."""

import dataclasses
import json

import pytest

from slcs2_jax.config import InputError, Settings, settings_to_dict
from slcs2_jax.results.documents import write_document
from slcs2_jax.results.sweep import SWEEP, runs_below, write_sweep

SETTINGS = Settings(instances=1)


def note(folder, name):
    plain = settings_to_dict(SETTINGS)
    write_document(folder / SWEEP, "sweep", 1, {"runs": {name: plain}})


def test_runs_that_have_not_begun_are_known(tmp_path):
    write_sweep(tmp_path, [dataclasses.replace(SETTINGS, run_dir=str(tmp_path / "a" / "b"))])
    assert list(json.loads((tmp_path / SWEEP).read_text())["runs"]) == ["a/b"]
    [run], others = runs_below(tmp_path)
    assert (run.run_dir, others) == (str(tmp_path / "a" / "b"), 0)


@pytest.mark.parametrize("name", ["..", "../x", "/x", "a/../../x", "C:\\x", "\x1b[2J", "", "a\nb"])
def test_a_name_that_leaves_the_folder_is_refused(name, tmp_path):
    note(tmp_path, name)
    with pytest.raises(InputError, match=r"sweep\.json: the name .* accepted is the name of a folder below this one"):
        runs_below(tmp_path)


def test_a_name_that_leads_through_a_link_is_refused(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "outside").mkdir()
    (tmp_path / "run" / "link").symlink_to(tmp_path / "outside")
    note(tmp_path / "run", "link/x")
    with pytest.raises(InputError, match="run/link: is a link; accepted is a folder"):
        runs_below(tmp_path / "run")


def test_links_to_folders_are_passed_over_and_told(tmp_path):
    (tmp_path / "outside").mkdir()
    note(tmp_path / "outside", "x")
    (tmp_path / "run").mkdir()
    note(tmp_path / "run", "y")
    (tmp_path / "run" / "link").symlink_to(tmp_path / "outside")
    passed = []
    found, _ = runs_below(tmp_path / "run", passed)
    assert [run.run_dir for run in found] == [str(tmp_path / "run" / "y")]
    assert passed == [f"{tmp_path / 'run' / 'link'}: is a link to a folder"]


def test_a_sweep_of_more_runs_than_can_be_read_back_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("slcs2_jax.results.sweep._LARGEST", 5000)
    runs = [dataclasses.replace(SETTINGS, run_dir=str(tmp_path / name)) for name in "ab"]
    with pytest.raises(InputError, match="2 runs would take over 5,000 bytes; accepted are fewer"):
        write_sweep(tmp_path, runs)
