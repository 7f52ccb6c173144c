"""Compiles the native chunk into the wheel where a C++ compiler and XLA's headers are at hand.

Else it is compiled when it is first wanted, or XLA computes everything.
"""

from __future__ import annotations

import importlib.util
import sysconfig
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NATIVE = Path("slcs2_jax/native")


def _load(path: Path) -> ModuleType:
    """The file alone: importing the package would need what it depends on."""
    spec = importlib.util.spec_from_file_location("native_build", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class NativeChunk(BuildHookInterface):
    """Adds a library for each instruction set to a wheel; an editable installation has none and compiles by itself."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Before the wheel is put together."""
        if self.target_name != "wheel" or version == "editable":
            return
        try:
            import jaxlib
        except ImportError:
            self.app.display_info("slcs2_jax: no jaxlib beside the build, so no native chunk inside the wheel")
            return
        build = _load(Path(self.root) / NATIVE / "build.py")
        include = str(Path(jaxlib.__file__).parent / "include")
        try:
            made = build.prebuild(Path(self.directory) / "native", include, f"jaxlib {jaxlib.__version__}")
        except build.BuildError as error:
            self.app.display_warning(f"slcs2_jax: {error}, so no native chunk inside the wheel")
            return
        for path in made:
            build_data["force_include"][str(path)] = str(NATIVE / "lib" / path.name)
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{platform}"  # the libraries know nothing of Python
