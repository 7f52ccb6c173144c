"""JAX's set-up for a run: devices and the cache of compiled programs, each in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from slcs2_jax import runtime
from slcs2_jax.config import Compute, InputError

PROGRAM = """
from slcs2_jax import runtime
from slcs2_jax.config import Compute
runtime.configure(Compute(devices={devices}, cache={cache}))
import jax, jax.numpy as jnp
jax.jit(lambda x: x + 1)(jnp.ones(3)).block_until_ready()
runtime.configure(Compute(cache={cache}))  # JAX runs already: nothing to set, and nothing wrong
print(len(jax.devices()))
"""


def devices_in_a_new_process(tmp_path: Path, devices: int | None = None, cache: bool = True, **variables: str) -> int:
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("JAX_", "XLA_"))}
    root = Path(runtime.__file__).parent.parent
    env = kept | {"PYTHONPATH": str(root), "XDG_CACHE_HOME": str(tmp_path / "home"), "JAX_PLATFORMS": "cpu"} | variables
    code = PROGRAM.format(devices=devices, cache=cache)
    done = subprocess.run(
        [sys.executable, "-c", code], env=env, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    return int(done.stdout)


def test_one_device_per_core_and_a_cache_in_the_users_folder(tmp_path):
    assert devices_in_a_new_process(tmp_path) == runtime.available_cores()
    assert list((tmp_path / "home" / "slcs2_jax" / "compiled").iterdir())


def test_devices_as_asked_for_and_no_cache(tmp_path):
    assert devices_in_a_new_process(tmp_path, devices=3, cache=False) == 3
    assert not (tmp_path / "home").exists()


def test_what_the_user_set_stands(tmp_path):
    flags = {
        "XLA_FLAGS": "--xla_force_host_platform_device_count=4",
        "JAX_COMPILATION_CACHE_DIR": str(tmp_path / "own"),
    }
    assert devices_in_a_new_process(tmp_path, devices=2, **flags) == 4
    assert list((tmp_path / "own").iterdir())
    assert not (tmp_path / "home").exists()


def test_more_devices_than_there_are():
    with pytest.raises(InputError, match=r"compute.devices=999: accepted is at most \d+, the cpu devices"):
        runtime.devices(Compute(devices=999))
    assert len(runtime.devices(Compute(devices=1))) == 1
