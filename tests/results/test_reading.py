"""A run's rows as data frames."""

import sys

import pytest

from slcs2_jax.config import InputError, Settings
from slcs2_jax.results import RunFolder, read_run


@pytest.fixture
def run(tmp_path):
    folder = RunFolder.create(Settings(instances=2, run_dir=str(tmp_path / "run")), device="cpu", kind="evolve")
    folder.append(
        {"instance": i, "generation": g, "best": (i + g) / 8, "contribution": [1.0, 0.5] if g else [0, 1.5]}
        for i in range(2)
        for g in range(3)
    )
    return read_run(folder.path)


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_row_for_each_generation(run, library):
    pytest.importorskip(library)
    frame = getattr(run, f"to_{library}")()
    assert frame.shape == (6, 4)
    assert list(frame["best"]) == [row["best"] for row in run.rows]
    assert list(frame["contribution"][0]) == [0, 1.5]


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_without_the_library_one_line_says_so(run, library, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=rf"to_{library}: .*slcs2_jax\[data\]"):
        getattr(run, f"to_{library}")()
