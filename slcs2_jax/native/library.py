"""The compiled library: found, or compiled, loaded once, and made known to JAX."""

from __future__ import annotations

import ctypes
import functools
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jaxlib import version as jaxlib
from numpy.typing import NDArray

from slcs2_jax import runtime
from slcs2_jax.native import build
from slcs2_jax.native.build import BuildError

CALLS = {"slcs2_advance": "Slcs2Advance", "slcs2_finish": "Slcs2Finish"}

_loaded: ctypes.CDLL | None = None


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
    global _loaded
    _loaded = library
    for name, symbol in CALLS.items():
        jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(getattr(library, symbol)), platform="cpu")


def lanes() -> int:
    """How many neighbouring episodes of a batch are computed side by side; groups that are all over cost nothing."""
    return 1 if _loaded is None else int(_loaded.slcs2_lanes())


def call(name: str, sizes: NDArray[np.int32], arrays: Sequence[NDArray[Any] | None], threads: int) -> None:
    """One of ``CALLS`` on arrays of the host, changed in place; None takes the place of one that is not there.

    The loaded library must be there (`reason_against`), and each array must be of the size that ``buffers.h`` says.
    """
    assert _loaded is not None
    assert all(array is None or array.flags.c_contiguous for array in arrays)
    pointers = (ctypes.c_void_p * len(arrays))(*(None if array is None else array.ctypes.data for array in arrays))
    if getattr(_loaded, name)(ctypes.c_void_p(sizes.ctypes.data), pointers, threads):
        raise MemoryError("the native chunk got no memory")


def _find() -> Path:
    """The library that was installed with the package, else one from the user's cache."""
    installed = build.PREBUILT / build.installed_name(build.level())
    versions = f"jaxlib {jaxlib.__version__}"
    told = installed.with_suffix(".txt")
    if installed.exists() and told.exists() and told.read_text() == f"{build.source_key()} {versions}":
        return installed
    return build.cached_library(runtime.cache_folder().parent / "native", jax.ffi.include_dir(), versions)
