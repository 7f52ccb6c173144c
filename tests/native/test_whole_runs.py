"""Whole searches in all worlds: the same bytes whatever the compiler, the vector width and the number of devices."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from slcs2_jax.results.run_folder import GENERATIONS, SOLUTIONS
from tests.native.test_bytes import USUAL, compiled, usable

WAYS = {"g++, 2 devices": ("", 2), "clang, 16 lanes": ("clang, 16 lanes", 1), "scalar, 2 devices": ("scalar", 2)}


def evolved(variant: str, devices: int, folder: Path) -> dict[str, bytes]:
    """What the runs leave, by name."""
    library = compiled(*(usable(variant) if variant else USUAL))
    command = [sys.executable, "-m", "tests.native.whole_runs", str(library), str(devices), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    files = [*folder.glob(f"*/{GENERATIONS}"), *folder.glob(f"*/{SOLUTIONS}/*")]
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


@pytest.mark.slow
def test_whole_searches_are_the_same_bytes(tmp_path: Path) -> None:
    expected = evolved("", 1, tmp_path / "usual")
    assert sum(name.endswith(GENERATIONS) for name in expected) == 9
    assert len(expected) > 9
    for name, (variant, devices) in WAYS.items():
        found = evolved(variant, devices, tmp_path / name)
        assert found.keys() == expected.keys()
        assert [file for file in found if found[file] != expected[file]] == [], name
