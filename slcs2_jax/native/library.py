"""The compiled library: found, or compiled, loaded once, and made known to JAX."""

from __future__ import annotations

import ctypes
import functools
import subprocess
from pathlib import Path

import jax
from jaxlib import version as jaxlib

from slcs2_jax import runtime
from slcs2_jax.native import build
from slcs2_jax.native.build import BuildError

CALLS = {"slcs2_advance": "Slcs2Advance", "slcs2_finish": "Slcs2Finish"}

_lanes = 1  # until a library is loaded


@functools.cache
def reason_against() -> str | None:
    """None if the native chunk can be called on CPUs from now on; else why not, in one line."""
    try:
        register(_find())
    except BuildError as error:
        return str(error)
    except (OSError, subprocess.SubprocessError, AttributeError, ValueError, RuntimeError) as error:
        return f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"
    return None


def register(path: Path) -> None:
    """Load a library and let JAX call it."""
    library = ctypes.CDLL(str(path))
    library.slcs2_key.restype = ctypes.c_char_p
    if library.slcs2_key().decode() != build.source_key():
        raise BuildError(f"{path}: it is of another version")
    global _lanes
    _lanes = int(library.slcs2_lanes())
    for name, symbol in CALLS.items():
        jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(getattr(library, symbol)), platform="cpu")


def lanes() -> int:
    """How many neighbouring episodes of a batch are computed side by side; groups that are all over cost nothing."""
    return _lanes


def _find() -> Path:
    """The library that was installed with the package, else one from the user's cache."""
    installed = build.PREBUILT / build.installed_name(build.level())
    versions = f"jaxlib {jaxlib.__version__}"
    told = installed.with_suffix(".txt")
    if installed.exists() and told.exists() and told.read_text() == f"{build.source_key()} {versions}":
        return installed
    return build.cached_library(runtime.cache_folder().parent / "native", jax.ffi.include_dir(), versions)
