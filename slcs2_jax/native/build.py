"""Compiling the native chunk: from a hatch hook at installation, and else when it is first wanted.

Imports nothing of the package and starts nothing, so that the build hook can load this file alone.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PREBUILT = HERE / "lib"
LEVELS = {
    "x86-64-v2": (),
    "x86-64-v3": ("avx2", "bmi2", "fma"),
    "x86-64-v4": ("avx512f", "avx512bw", "avx512dq", "avx512vl"),
}
FLAGS = ("-std=c++17", "-O3", "-fno-math-errno", "-ffp-contract=off", "-fPIC", "-shared", "-pthread", "-Wno-psabi")
SECONDS = 120  # that a compiler may take


class BuildError(Exception):
    """There is no library, and the message says in one line why."""


def level() -> str | None:
    """The instruction sets of this processor: the last of ``LEVELS`` that it has; None for other than x86-64."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return None
    have: set[str] = set()
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        have = set(next((line for line in lines if line.startswith("flags")), "").split())
    return [name for name, needed in LEVELS.items() if have.issuperset(needed)][-1]


def compiler() -> str:
    """The C++ compiler: $CXX, else the first of c++, g++ and clang++. Raises BuildError if there is none."""
    named = os.environ.get("CXX")
    for name in [named] if named else ["c++", "g++", "clang++"]:
        if path := shutil.which(name):
            return path
    raise BuildError(f"there is no C++ compiler ({f'CXX={named}' if named else 'c++, g++ or clang++'})")


def sources() -> list[Path]:
    """The C++ files, in a fixed order."""
    return sorted(HERE.glob("*.h")) + sorted(HERE.glob("*.cc"))


def source_key() -> str:
    """Names what the C++ files say."""
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def command(compiler: str, include: str, level: str | None, output: Path, extra: tuple[str, ...] = ()) -> list[str]:
    """How the library is compiled; ``include``: the folder of XLA's headers."""
    architecture = () if level is None else (f"-march={level}",)
    key = f'-DSLCS2_KEY="{source_key()}"'
    main = str(HERE / "chunk.cc")
    return [compiler, *FLAGS, *architecture, *extra, key, "-isystem", include, main, "-o", str(output)]


def compile_library(output: Path, include: str, level: str | None, extra: tuple[str, ...] = ()) -> None:
    """Compile the library and put it in its place at once, whole. Raises BuildError."""
    scratch = None
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        handle, scratch = tempfile.mkstemp(suffix=".so", dir=output.parent)
        os.close(handle)
        arguments = command(compiler(), include, level, Path(scratch), extra)
        made = subprocess.run(arguments, capture_output=True, text=True, timeout=SECONDS, check=False)
        if made.returncode != 0:
            lines = [line for line in made.stderr.splitlines() if "error" in line] or made.stderr.splitlines()
            raise BuildError(f"{arguments[0]} fails ({lines[0][:200] if lines else f'exit {made.returncode}'})")
        os.replace(scratch, output)
        scratch = None
    except subprocess.TimeoutExpired:
        raise BuildError(f"the C++ compiler takes more than {SECONDS} s") from None
    except OSError as error:
        raise BuildError(f"{error.filename or output}: {error.strerror or error}") from None
    finally:
        if scratch is not None:
            with contextlib.suppress(OSError):
                os.unlink(scratch)


def prebuild(folder: Path, include: str, versions: str) -> list[Path]:
    """One library for each instruction set that processors like this one may have, and what each was made of.

    Raises BuildError.
    """
    made = []
    for name in LEVELS if level() is not None else (None,):
        library = folder / installed_name(name)
        compile_library(library, include, name)
        label = library.with_suffix(".txt")
        label.write_text(f"{source_key()} {versions}")
        made += [library, label]
    return made


def installed_name(level: str | None) -> str:
    """File name of the library for an instruction set inside the package."""
    return f"chunk-{level or 'default'}.so"


def cached_library(folder: Path, include: str, versions: str) -> Path:
    """The library from a cache folder, compiled if it is not there yet; ``versions``: of what it is linked with.

    Raises BuildError.
    """
    path = compiler()
    told = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=SECONDS, check=False).stdout
    parts = (source_key(), versions, told, *command(path, include, level(), Path("library")))
    library = folder / f"chunk-{hashlib.sha256('|'.join(parts).encode()).hexdigest()[:24]}.so"
    if not library.exists():
        compile_library(library, include, level())
    return library
