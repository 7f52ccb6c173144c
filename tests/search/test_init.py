from __future__ import annotations

import subprocess
import sys


def test_importing_the_search_does_not_start_jax():
    code = "import sys, slcs2_jax.search; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
