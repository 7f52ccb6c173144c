"""Every file in examples/ runs as its user runs it: by itself, in a folder of his own, from beginning to end."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
MOST_LINES = 75


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs_and_prints_something(example, tmp_path):
    known = os.environ | {"PYTHONPATH": str(ROOT), "JAX_PLATFORMS": "cpu", "PYTHONWARNINGS": "default"}
    done = subprocess.run(
        [sys.executable, str(example)], cwd=tmp_path, env=known, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) >= 2
    assert "Warning" not in done.stderr


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_it_is_short_and_says_how_it_is_run(example):
    text = example.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= MOST_LINES
    told = ast.get_docstring(ast.parse(text))
    assert told is not None
    assert f"python examples/{example.name}" in told
