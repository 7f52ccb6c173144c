"""A part of a benchmark in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config import InputError


def tables_of(module: str, arguments: Sequence[object]) -> dict[str, list[dict[str, Any]]]:
    """Run a benchmark and return its tables; raises InputError with its last line if it ends otherwise than well."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "figures.json"
        command = [sys.executable, "-m", f"benchmarks.{module}", *map(str, arguments), "--json", str(path)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise InputError(f"{' '.join(command[2:-2])}: ended with code {done.returncode}: {reason}")
        return json.loads(path.read_text())["tables"]
