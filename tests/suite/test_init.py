"""The floor: listing and tabulating read files and never start JAX."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize("arguments", [["list"], ["table", "run_dir=nothing"]])
def test_reading_does_not_import_jax(arguments, tmp_path):
    code = (
        "import sys; from slcs2_jax import cli; from slcs2_jax.suite import page, rows, table; "
        f"cli.main(['suite', *{arguments!r}]); print('jax' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert found.stdout.splitlines()[-1] == "False"
