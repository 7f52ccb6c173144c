"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

from slcs2_jax import runtime
from slcs2_jax.config import Compute
from slcs2_jax.results.run_config import versions


def processor() -> str:
    """The model of the processor, as the system calls it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def describe(compute: Compute) -> dict[str, Any]:
    """Processor, cores, memory, devices and versions. Starts JAX."""
    found = versions()
    for name in ("numba", "llvmlite"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "none"
    return {
        "processor": processor(),
        "cores": runtime.available_cores(),
        "memory_gib": round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30, 1),
        "load_before": [round(load, 2) for load in os.getloadavg()],
        "system": platform.platform(),
        "devices": runtime.describe_devices(compute),
        "versions": found,
    }


def in_words(machine: dict[str, Any]) -> str:
    """One line of a report."""
    tools = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_gib']:g} GiB; "
        f"devices: {machine['devices']}; load before: {machine['load_before'][0]:g}; {tools}"
    )
