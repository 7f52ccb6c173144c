"""slcs2 repeat: make a finished run again from what its folder records, and compare."""

from __future__ import annotations

import contextlib
import dataclasses
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.changes import changed, folder_and_changes
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import show
from slcs2_jax.config.registry import KINDS

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.results.run_config import RunConfig

TAKES_SETTINGS = False
HELP = """\
slcs2 repeat FOLDER [into=DIR]: make the finished run in FOLDER again, and say file by file whether it came to the same

Settings, grammar, batch width and seeds are those that FOLDER records.
  into=DIR              keep the repeated run there; without it, it is thrown away
  compute.devices=N     how many devices are used now; their number changes no bit
Exit code: 0 every file of the results is the same, 3 one differs, 2 bad input, 130 or 143 interrupted.
"""
_ACCEPTED = ("into", "compute.devices", "compute.cache")
_NOT_MATCHED = 3


def run(arguments: list[str]) -> int:
    """Repeat what the folder records."""
    name, changes = folder_and_changes("repeat", arguments, _ACCEPTED)
    from slcs2_jax.results.run_config import read_config
    from slcs2_jax.results.run_folder import check_free, read_grammar

    folder, into = Path(name), changes.pop("into", None)
    config = read_config(folder)
    _check_repeatable(folder, config)
    grammar = read_grammar(folder, config)
    if into is not None:
        check_free(str(into))
    settings = changed(config.settings, changes)
    with _place(into) as place:
        _repeat(dataclasses.replace(settings, run_dir=str(place)), config, grammar)
        return _compare(folder, place)


def _check_repeatable(folder: Path, config: RunConfig) -> None:
    from slcs2_jax.results.reading import read_summary

    label = f"folder={show(str(folder))}"
    if not config.evolves:
        raise InputError(f"{label}: holds an evaluation; accepted is a run of evolution")
    KINDS["search"].get(config.settings.search.name)
    if read_summary(folder, config) is None:
        raise InputError(f"{label}: is not finished; accepted is a finished run (slcs2 resume {folder} finishes it)")


@contextlib.contextmanager
def _place(into: Any) -> Iterator[Path]:
    if into is not None:
        yield Path(str(into))
        return
    with tempfile.TemporaryDirectory(prefix="slcs2-repeat-") as scratch:
        yield Path(scratch) / "run"


def _repeat(settings: Settings, config: RunConfig, grammar: str) -> None:
    from slcs2_jax import runtime
    from slcs2_jax.results import Progress, RunFolder

    runtime.configure(settings.compute)
    from slcs2_jax.running import driver

    device = runtime.describe_devices(settings.compute)
    if changes := config.changes(device):
        print(f"{changes}: the same bytes are not to be expected")
    record = {"width": config.record["width"]}
    RunFolder.open(settings, device=device, grammar_text=lambda: grammar, record=record).close()
    with Progress(settings.search.generations) as report:
        driver.evolve([settings], report=report, as_begun=True)


def _compare(one: Path, other: Path) -> int:
    """Print a line for each file of results; 0 if all are the same."""
    before, now = _results(one), _results(other)
    differing = 0
    for name in sorted(before.keys() | now.keys()):
        if name not in now or name not in before:
            words = "only in the repeated run" if name in now else "not in the repeated run"
        else:
            words = "same" if before[name] == now[name] else "DIFFERS" + _where(name, before[name], now[name])
        differing += words != "same"
        print(f"{name:40} {words}")
    print("it came to the same" if not differing else f"{differing} files differ", flush=True)
    return _NOT_MATCHED if differing else 0


def _results(folder: Path) -> dict[str, bytes]:
    from slcs2_jax.results.run_folder import CHECKPOINT, GENERATIONS, GRAMMAR, SOLUTIONS, SUMMARY

    files = [folder / name for name in (CHECKPOINT, GENERATIONS, GRAMMAR, SUMMARY)]
    files += [path for path in (folder / SOLUTIONS).glob("*") if path.suffix in (".npz", ".txt")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files if path.is_file()}


def _where(name: str, before: bytes, now: bytes) -> str:
    if not name.endswith(".jsonl"):
        return ""
    pairs = zip(before.splitlines(), now.splitlines(), strict=False)
    first = next((line for line, (old, new) in enumerate(pairs, start=1) if old != new), None)
    return "" if first is None else f", first in line {first}"
