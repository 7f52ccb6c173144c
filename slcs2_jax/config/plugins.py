"""Plug-ins: a user's modules that register parts, imported because the user names them in this very command.

A file never causes an import: a run folder records which plug-ins its run was begun with, and the run goes on only if
the user names them again and their source is what it was.
"""

from __future__ import annotations

import hashlib
import importlib
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slcs2_jax.config.errors import InputError, refuse, show

SETTING = "plugins"

_loaded: dict[str, str] = {}  # by name, the digest of each that was imported in this process


def named_in(arguments: Sequence[str]) -> tuple[str, ...]:
    """The modules in `plugins=[my_module,...]` or `plugins=my_module` among a command's arguments, the last such."""
    found: tuple[str, ...] = ()
    for argument in arguments:
        name, equals, text = argument.partition("=")
        if name == SETTING and equals:
            inner = text.strip()
            inner = inner[1:-1] if inner[:1] == "[" and inner[-1:] == "]" else inner
            found = tuple(entry.strip().strip("'\"") for entry in inner.split(",")) if inner.strip() else ()
    return found


def loaded() -> dict[str, str]:
    """Of each plug-in that was loaded in this process, the SHA-256 (hex) of its source then."""
    return dict(_loaded)


def load(modules: Sequence[str]) -> dict[str, str]:
    """Import each module, which registers its parts; returns of each the SHA-256 (hex) of its source file.

    Modules are looked for where Python looks, and in the current folder. Raises InputError naming the one that cannot
    be imported, and why.
    """
    found = {name: _load(name) for name in modules}
    _loaded.update(found)
    return found


def _load(name: str) -> str:
    if not isinstance(name, str) or not all(part.isidentifier() for part in name.split(".")):
        raise refuse(SETTING, name, "names of Python modules, plugins=[my_module]")
    here = str(Path.cwd())
    looked = here not in sys.path
    if looked:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(name)
    except InputError as error:
        raise InputError(f"{SETTING}={name}: {error}") from None
    except ModuleNotFoundError as error:
        if error.name == name.split(".")[0] or error.name == name:
            raise refuse(SETTING, name, "the name of a module in the current folder or on Python's path") from None
        raise _broken(name, error) from None
    except Exception as error:
        raise _broken(name, error) from None
    finally:
        if looked:
            sys.path.remove(here)
    return _digest(module)


def _broken(name: str, error: Exception) -> InputError:
    return InputError(f"{SETTING}={name}: its import failed ({type(error).__name__}: {show(str(error))})")


def _digest(module: Any) -> str:
    file = getattr(module, "__file__", None)
    source = Path(file).read_bytes() if file else b""
    return hashlib.sha256(source).hexdigest()


def check_same(recorded: Mapping[str, str], loaded: Mapping[str, str], where: str) -> None:
    """Raise InputError unless every plug-in recorded at `where` is loaded, with the source it had then."""
    missing = [name for name in recorded if name not in loaded]
    if missing:
        names = ",".join([*loaded, *missing])
        raise InputError(
            f"{where}: was made with the plug-in {missing[0]}, and no file may import it; accepted is "
            f"{SETTING}=[{names}], if you trust it"
        )
    for name, digest in recorded.items():
        if loaded[name] != digest:
            raise InputError(
                f"{where}: the plug-in {name} has changed since; accepted is its source of then (SHA-256 "
                f"{digest[:12]}...), or another run_dir"
            )
