"""Run folders read: by people's scripts, by other commands, and by a run that goes on."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.arguments import path_of, whole
from slcs2_jax.config.door import present
from slcs2_jax.config.field import show
from slcs2_jax.results.documents import read_document
from slcs2_jax.results.files import names_in, storing
from slcs2_jax.results.rows import read_rows
from slcs2_jax.results.run_config import RunConfig, read_config
from slcs2_jax.results.run_folder import (
    GENERATIONS,
    SUMMARY,
    SUMMARY_VERSION,
    TIMING,
    TIMING_VERSION,
    check_usable,
    most_rows,
)
from slcs2_jax.results.saved import SOLUTIONS, SavedSolution, load_solution
from slcs2_jax.results.summary import RunSummary

if TYPE_CHECKING:
    import pandas
    import polars


@dataclass(frozen=True)
class FinishedRun:
    """A run folder that is read; of an unfinished run the summary is None and the rows are those there are."""

    path: Path
    settings: Settings
    record: dict[str, Any]
    rows: tuple[dict[str, Any], ...]
    summary: dict[str, Any] | None
    timing: dict[str, Any] | None

    def best(self, instance: int) -> SavedSolution:
        """The best solution of an instance. Raises InputError if there is none such, or not yet."""
        instance = whole("instance", instance, 0, self.settings.instances - 1)
        return load_solution(self.path / SOLUTIONS / f"instance_{instance:03d}_best.npz")

    def members(self, instance: int) -> list[SavedSolution]:
        """The final collection of an instance; empty before the run has ended. Raises InputError."""
        instance = whole("instance", instance, 0, self.settings.instances - 1)
        prefix = f"instance_{instance:03d}_member_"
        names = names_in(self.path / SOLUTIONS, inside=self.path)
        found = [name for name in names if name.startswith(prefix) and name.endswith(".npz")]
        return [load_solution(self.path / SOLUTIONS / name) for name in found]

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each generation of each instance, with the columns of generations.jsonl.

        Raises InputError if pandas is not installed.
        """
        return _module("pandas").DataFrame(list(self.rows))

    def to_polars(self) -> polars.DataFrame:
        """As `to_pandas`. Raises InputError if polars is not installed."""
        return _module("polars").DataFrame(list(self.rows), infer_schema_length=None, strict=False)


def _module(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise InputError(
            f"to_{name}: {name} is not installed; accepted is an installation with slcs2_jax[data]"
        ) from None


def read_run(path: str | Path) -> FinishedRun:
    """Read a run folder, finished (its summary is there) or not. Raises InputError naming a missing or damaged file."""
    folder = path_of("run", path)
    config = read_config(folder)
    summary = read_summary(folder, config)
    file = folder / GENERATIONS
    try:
        rows = read_rows(file, most_rows(config.settings)) if present(file) else []
        if summary is not None and config.evolves:
            _check_complete(rows, summary)
    except InputError as error:
        raise InputError(f"{file}: {error}; slcs2 resume {folder} says what can be done") from None
    return FinishedRun(folder, config.settings, config.record, tuple(rows), summary, read_timing(folder))


def read_summary(folder: Path, config: RunConfig) -> dict[str, Any] | None:
    """The summary of a run that has ended, None of one that goes on. Raises InputError naming a damaged file."""
    settings = config.settings
    most = 2**18 + 512 * settings.instances + 128 * settings.search.fresh_deployments
    summary = _document(folder / SUMMARY, "summary", SUMMARY_VERSION, most)
    if summary is not None and config.evolves and summary.get("generations") != config.settings.search.generations:
        return None  # that of a shorter run: this one was just about to go further
    return summary


def look(settings: Settings) -> tuple[RunConfig | None, RunSummary | None]:
    """What `settings.run_dir` holds: the configuration of the same run, if it was begun, and the summary, if all the
    generations that are asked for are made.

    Raises InputError if the folder holds another run, or naming a damaged file.
    """
    config = check_usable(settings)
    if config is None or config.settings.search.generations != settings.search.generations:
        return config, None
    folder = Path(str(settings.run_dir))
    summary = read_summary(folder, config)
    if summary is None:
        return config, None
    try:
        return config, RunSummary.from_json(str(folder), summary, read_timing(folder))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{folder / SUMMARY}: {show(str(error))}; delete it, and slcs2 resume makes it again"
        ) from None


def ended(settings: Settings) -> RunSummary | None:
    """The summary of the run that `settings.run_dir` holds, if it has ended; see `look`."""
    return None if settings.run_dir is None else look(settings)[1]


def read_timing(folder: Path) -> dict[str, Any] | None:
    """How long the run took so far, None if that was not written yet. Raises InputError naming a damaged file."""
    return _document(folder / TIMING, "timing", TIMING_VERSION, 2**16)


def _document(file: Path, kind: str, version: int, most: int) -> dict[str, Any] | None:
    if not present(file):
        return None
    try:
        with storing(file, "read"):
            return read_document(file, kind, version, most)
    except InputError as error:
        raise InputError(f"{file}: {show(str(error))}; delete it, and slcs2 resume makes it again") from None


def _check_complete(rows: list[dict[str, Any]], summary: dict[str, Any]) -> None:
    found = {(row.get("generation"), row.get("instance")) for row in rows}
    expected = sum(instance["generations"] for instance in summary["instances"])
    if len(rows) != expected or len(found) != expected:
        raise InputError(f"{len(rows)} rows of a run that ended with {expected}: damaged or cut short")
