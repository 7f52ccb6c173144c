"""sweep.json: which runs a sweep consists of, so that those that had not begun when it was interrupted are not lost."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from slcs2_jax.config import InputError, Settings, plugins, settings_from, settings_to_dict
from slcs2_jax.config.door import check_below, folders_below, name_inside, present, telling_damage
from slcs2_jax.config.field import show
from slcs2_jax.config.registry import any_name
from slcs2_jax.results.documents import read_document, write_document
from slcs2_jax.results.files import storing
from slcs2_jax.results.progress import counted
from slcs2_jax.results.run_config import CONFIG, check_same, check_writable, read_config
from slcs2_jax.results.run_folder import CHECKPOINT, GENERATIONS, GRAMMAR, SUMMARY

SWEEP = "sweep.json"
_VERSION = 1
_LARGEST = 2**26  # bytes of the note: some 20 000 runs, or 200 in a large world of the user's own


def write_sweep(root: str | Path, runs: Sequence[Settings]) -> None:
    """Note in the folder `root` that these runs, each with a run_dir below it, belong to a sweep.

    Runs noted there before stay. Raises InputError if the note is damaged, StorageError.
    """
    folder = check_writable(root)
    with storing(folder, "made"):
        folder.mkdir(parents=True, exist_ok=True)
    before = _read(folder)
    noted = before | {Path(os.path.relpath(str(one.run_dir), folder)).as_posix(): _plain(one) for one in runs}
    if len(json.dumps(noted, indent=2)) > _LARGEST - 1000:
        raise InputError(
            f"{folder / SWEEP}: {len(noted):,} runs would take over {_LARGEST:,} bytes; accepted are fewer runs in one "
            "folder"
        )
    if noted != before:
        write_document(folder / SWEEP, "sweep", _VERSION, {"runs": noted})


def runs_below(root: str | Path, passed: list[str] | None = None) -> tuple[list[Settings], int]:
    """Every run of evolution in a folder and below it, begun or not, and how many evaluations lie beside them.

    Links are not followed; `passed` gets a line for each folder that was passed over.

    The settings are those that the runs were made with (the later ones of a sweep that was told to go further), with
    `run_dir` where they lie now, in the order of their folders.

    Raises InputError if there are none, or naming a damaged file.
    """
    top = Path(root)
    if not top.is_dir():
        raise InputError(f"folder={show(str(root))}: no such folder; accepted is the folder of a run or of several")
    found: dict[Path, Settings] = {}
    others = 0
    folders = list(folders_below(top, passed))
    for folder in counted(folders, "folders looked into:"):
        if not _is_run(folder):
            continue
        config = read_config(folder)
        if config.evolves:
            found[folder] = config.settings
        else:
            others += 1
    for folder in folders:
        for name, plain in _read(folder).items():
            place = folder / name
            check_below(folder, place)
            settings = _settings(plain, folder / SWEEP)
            if place in found:
                check_same(replace(settings, search=found[place].search), found[place], place)
            if place not in found or settings.search.generations > found[place].search.generations:
                found[place] = settings
    if not found and not others:
        raise InputError(f"folder={show(str(root))}: holds no run; accepted is the folder of a run or of several")
    return [replace(found[folder], run_dir=str(folder)) for folder in sorted(found)], others


def _is_run(folder: Path) -> bool:
    """A config.yaml alone may be anybody's."""
    ours = (GRAMMAR, GENERATIONS, CHECKPOINT, SUMMARY)
    return present(folder / CONFIG) and any(present(folder / name) for name in ours)


def _plain(settings: Settings) -> dict[str, Any]:
    return settings_to_dict(replace(settings, run_dir=None))


def _settings(plain: Any, file: Path) -> Settings:
    try:
        with telling_damage(), any_name():
            return settings_from(plain)
    except plugins.PluginError as error:
        raise plugins.PluginError(f"{file}: {error}") from None
    except InputError as error:
        raise InputError(f"{file}: {show(str(error))}; delete it and repeat the command of the sweep") from None


def _read(folder: Path) -> dict[str, Any]:
    file = folder / SWEEP
    if not present(file):
        return {}
    try:
        with storing(file, "read"):
            content = read_document(file, "sweep", _VERSION, _LARGEST)
        with telling_damage():
            return {str(name_inside(name)): plain for name, plain in dict(content["runs"]).items()}
    except InputError as error:
        raise InputError(f"{file}: {show(str(error))}; delete it and repeat the command of the sweep") from None
