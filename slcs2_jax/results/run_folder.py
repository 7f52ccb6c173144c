"""The folder of one run: config.yaml, generations.jsonl, solutions/ and summary.json. Nothing is ever overwritten."""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from slcs2_jax import __version__
from slcs2_jax.config import InputError, Settings, settings_from, settings_to_dict
from slcs2_jax.config.field import show
from slcs2_jax.results.files import write_json
from slcs2_jax.results.saved import SavedSolution, load_solution

CONFIG, GENERATIONS, SOLUTIONS, SUMMARY = "config.yaml", "generations.jsonl", "solutions", "summary.json"
_OURS = (CONFIG, GENERATIONS, SOLUTIONS, SUMMARY)


def check_free(path: str | Path) -> Path:
    """The folder as a Path if a new run may use it; raises InputError naming it otherwise. Makes nothing."""
    folder = Path(path)
    label = f"run_dir={show(str(path))}"
    for parent in (folder, *folder.parents):
        if parent.exists():
            if not parent.is_dir():
                raise InputError(f"{label}: {parent} is a file; accepted is a folder that is new or holds no run")
            if not os.access(parent, os.W_OK | os.X_OK):
                raise InputError(f"{label}: {parent} cannot be written to; accepted is a folder that can")
            break
    taken = [name for name in _OURS if (folder / name).exists()]
    if taken:
        raise InputError(f"{label}: already holds a run ({taken[0]}); accepted is a folder that is new or holds none")
    return folder


def versions() -> dict[str, str]:
    """Versions of this package, Python, and what decides its results."""
    found = {"slcs2_jax": __version__, "python": platform.python_version()}
    for name in ("jax", "jaxlib", "numpy"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


@dataclass(frozen=True)
class RunFolder:
    """The folder of a run that is being written."""

    path: Path

    @classmethod
    def create(cls, settings: Settings, *, device: str, record: Mapping[str, Any] | None = None) -> RunFolder:
        """Make `settings.run_dir` and its config.yaml, which keeps `record` beside time, command, device and versions.

        Raises InputError if the folder holds a run or cannot be written.
        """
        from omegaconf import OmegaConf

        if settings.run_dir is None:
            raise InputError("run_dir=null: accepted is the path of a folder")
        folder = check_free(settings.run_dir)
        kept: dict[str, Any] = {
            "started": datetime.now().astimezone().isoformat(timespec="seconds"),
            "command": " ".join([Path(sys.argv[0]).name, *sys.argv[1:]]) if sys.argv else "",
            "device": device,
            "versions": versions(),
            **(record or {}),
        }
        text = OmegaConf.to_yaml(OmegaConf.create(settings_to_dict(settings) | {"record": kept}))
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with (folder / CONFIG).open("x", encoding="utf-8") as file:
                file.write(text)
        except FileExistsError:
            raise InputError(
                f"run_dir={show(settings.run_dir)}: already holds a run; accepted is a new folder"
            ) from None
        except OSError as error:
            raise InputError(f"run_dir={show(settings.run_dir)}: cannot be made ({error.strerror})") from None
        return cls(folder)

    def append(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows (one per instance and generation) to generations.jsonl. Raises ValueError for NaN or infinity."""
        text = "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)
        with (self.path / GENERATIONS).open("a", encoding="utf-8") as file:
            file.write(text)

    def save_best(self, instance: int, solution: SavedSolution) -> Path:
        """solutions/instance_000_best.npz and .txt; returns the .npz's path."""
        return self._save(f"instance_{instance:03d}_best", solution)

    def save_member(self, instance: int, member: int, solution: SavedSolution) -> Path:
        """solutions/instance_000_member_000.npz and .txt, one member of the final collection."""
        return self._save(f"instance_{instance:03d}_member_{member:03d}", solution)

    def _save(self, name: str, solution: SavedSolution) -> Path:
        path = self.path / SOLUTIONS / f"{name}.npz"
        path.parent.mkdir(exist_ok=True)
        solution.save(path)
        solution.save_text(path.with_suffix(".txt"))
        return path

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """summary.json, whole or not at all; its presence says that the run ended."""
        write_json(self.path / SUMMARY, dict(summary))


@dataclass(frozen=True)
class FinishedRun:
    """A run folder that is read."""

    path: Path
    settings: Settings
    record: dict[str, Any]
    rows: tuple[dict[str, Any], ...]
    summary: dict[str, Any] | None

    def best(self, instance: int) -> SavedSolution:
        """The best solution of an instance."""
        return load_solution(self.path / SOLUTIONS / f"instance_{instance:03d}_best.npz")

    def members(self, instance: int) -> list[SavedSolution]:
        """The final collection of an instance."""
        return [
            load_solution(path)
            for path in sorted((self.path / SOLUTIONS).glob(f"instance_{instance:03d}_member_*.npz"))
        ]


def read_run(path: str | Path) -> FinishedRun:
    """Read a run folder, finished (its summary is there) or not. Raises InputError naming a missing or damaged file."""
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException
    from yaml import YAMLError  # type: ignore[import-untyped]

    folder = Path(path)
    file = folder / CONFIG
    try:
        config: Any = OmegaConf.to_container(OmegaConf.load(file), resolve=False)
        record = config.pop("record")
        settings = settings_from(config)
        file = folder / GENERATIONS
        text = file.read_text(encoding="utf-8") if file.exists() else ""
        rows = [_parse(line) for line in text[: text.rfind("\n") + 1].splitlines()]  # a last line cut short is no row
        file = folder / SUMMARY
        summary = _parse(file.read_text(encoding="utf-8")) if file.exists() else None
    except (OSError, ValueError, KeyError, AttributeError, TypeError, YAMLError, OmegaConfBaseException) as error:
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{file}: not a file of a run folder of slcs2 ({reason})") from None
    return FinishedRun(folder, settings, record, tuple(rows), summary)


def _parse(text: str) -> dict[str, Any]:
    def refuse(name: str) -> None:
        raise ValueError(f"{name} is no finite number")

    value = json.loads(text, parse_constant=refuse)
    if not isinstance(value, dict):
        raise ValueError("a JSON object is expected")
    return value
