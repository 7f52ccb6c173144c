"""The floor: comparing runs reads folders and never starts JAX; the calibration study computes, and imports it then."""

import subprocess
import sys


def test_analysis_does_not_import_jax():
    code = (
        "import sys; from slcs2_jax.study import calibrate, figure, page, report; "
        "from slcs2_jax.commands import experiment; print('jax' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"
