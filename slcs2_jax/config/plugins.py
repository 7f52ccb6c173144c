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


class PluginError(InputError):
    """What a file holds was made with a plug-in that is not loaded, or is another one now."""


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


def forget(name: str) -> None:
    """Count a plug-in as not loaded; for tests and notebooks."""
    _loaded.pop(name, None)


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


def check_same(record: Mapping[str, Any], where: str) -> None:
    """Raise PluginError unless every plug-in in a file's record is loaded, with the source it had then.

    Raises TypeError or ValueError if the entry is damaged.
    """
    recorded = {str(name): str(digest) for name, digest in dict(record.get(SETTING, {})).items()}
    check_named(list(recorded), where)
    for name, digest in recorded.items():
        if _loaded[name] != digest:
            raise PluginError(
                f"{where}: the plug-in {name} has changed since; accepted is its source of then (SHA-256 "
                f"{digest[:12]}...), or another run_dir"
            )


def check_named(modules: object, where: str) -> None:
    """Raise PluginError unless each of the modules that settings name is loaded; what is no list of names passes."""
    if not isinstance(modules, list | tuple):
        return
    missing = [name for name in modules if isinstance(name, str) and name not in _loaded]
    if missing:
        names = ",".join(show(name) for name in modules)
        raise PluginError(
            f"{where}: needs the plug-in {show(missing[0])}, which is imported only if you name it; accepted is "
            f"{SETTING}=[{names[:200]}], if you trust it"
        )


def recorded(modules: Sequence[str]) -> dict[str, dict[str, str]]:
    """The entry in a file's record for settings with these plug-ins, to be checked with `check_same`; {} for none."""
    return {SETTING: {name: _loaded.get(name, "") for name in modules}} if modules else {}
