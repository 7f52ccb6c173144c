"""How JAX is set up for a run: CPU devices and the cache of compiled programs. Call before anything is computed."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Any

from slcs2_jax.config import Compute
from slcs2_jax.config.field import refuse


def available_cores() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def cache_folder() -> Path:
    """Where compiled programs are kept: slcs2_jax below the user's cache folder."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "slcs2_jax" / "compiled"


def configure(compute: Compute) -> None:
    """Set the number of CPU devices, one thread for each, and the compilation cache; start JAX.

    What the user set (XLA_FLAGS, JAX_NUM_CPU_DEVICES, NPROC, JAX_COMPILATION_CACHE_DIR and its companions) stands.
    Where JAX runs already, its devices stay as they are.
    """
    import jax

    values: Any = jax.config  # its settings are attributes made at run time
    forced = "xla_force_host_platform_device_count" in os.environ.get("XLA_FLAGS", "")
    if not forced and values.jax_num_cpu_devices < 0:
        with contextlib.suppress(RuntimeError):
            jax.config.update("jax_num_cpu_devices", compute.devices or available_cores())
    if compute.cache:
        _configure_cache(jax)
    _start_with_one_thread_per_device(jax)


def _start_with_one_thread_per_device(jax: Any) -> None:
    """XLA shares long kernels out to as many threads as there are cores. But each core is a device already, or belongs
    to another process, and waiting for the other threads costs more than they save."""
    if "NPROC" in os.environ:
        jax.devices()
        return
    os.environ["NPROC"] = "1"
    try:
        jax.devices()
    finally:
        del os.environ["NPROC"]


def _configure_cache(jax: Any) -> None:
    if not jax.config.jax_compilation_cache_dir:
        folder = cache_folder()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:  # no home to write to: run without
            return
        jax.config.update("jax_compilation_cache_dir", str(folder))
    if "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS" not in os.environ:
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    if "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES" not in os.environ:
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def devices(compute: Compute) -> list[Any]:
    """The devices a run uses: the first `compute.devices` of the default backend, or all. Starts JAX."""
    import jax

    found = jax.devices()
    if compute.devices is None:
        return found
    if compute.devices > len(found):
        raise refuse(
            "compute.devices",
            compute.devices,
            f"at most {len(found)}, the {found[0].platform} devices that JAX started with",
        )
    return found[: compute.devices]


def describe_devices(compute: Compute) -> str:
    """In words, what a run computes on: `2 x cpu (cpu)`, `1 x NVIDIA H200 (gpu)`."""
    used = devices(compute)
    return f"{len(used)} x {used[0].device_kind} ({used[0].platform})"
