"""slcs2 repeat: make a finished run again from what its folder records, and compare."""

from __future__ import annotations

import contextlib
import dataclasses
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.changes import changed, folder_and_changes
from slcs2_jax.config.door import present, reading
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.field import show
from slcs2_jax.config.registry import KINDS
from slcs2_jax.results.files import names_in, storing

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.results.run_config import RunConfig

TAKES_SETTINGS = False
HELP = """\
slcs2 repeat FOLDER [into=DIR]: make the finished run in FOLDER again, and say file by file whether it came to the same

Settings, grammar, knowledge, batch width and seeds are those that FOLDER records.
  into=DIR              keep the repeated run there; without it, it is thrown away
  compute.devices=N     how many devices are used now; their number changes no bit
What an archive has not kept, files or columns of generations.jsonl, is no difference.
Exit code: 0 every file of the results that is there is the same, 3 one differs, 2 bad input, 130 or 143 interrupted.
"""
OPTIONS = ("into", "compute.devices", "compute.cache")
_NOT_MATCHED = 3
_LARGEST = 2**50  # bytes of a file that is compared; no more of it is read than the repeated one has


def run(arguments: list[str]) -> int:
    """Repeat what the folder records."""
    name, changes = folder_and_changes("repeat", arguments, OPTIONS)
    from slcs2_jax.results.run_config import read_config
    from slcs2_jax.results.run_folder import GRAMMAR, KNOWLEDGE, check_free, read_grammar, read_knowledge

    folder, into = Path(name), changes.pop("into", None)
    config = read_config(folder)
    _check_repeatable(folder, config)
    _files(folder)
    texts = {GRAMMAR: read_grammar(folder, config)}
    if (known := read_knowledge(folder, config)) is not None:
        texts[KNOWLEDGE] = known
    if into is not None:
        check_free(str(into))
    settings = changed(config.settings, changes)
    with _place(into) as place:
        _repeat(dataclasses.replace(settings, run_dir=str(place), logger="none"), config, texts)
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


def _repeat(settings: Settings, config: RunConfig, texts: Mapping[str, str]) -> None:
    from slcs2_jax import runtime
    from slcs2_jax.native.choice import computed_on
    from slcs2_jax.results import Progress, RunFolder

    runtime.configure(settings.compute)
    from slcs2_jax.running import driver

    device = computed_on(settings.compute)
    if changes := config.changes(device):
        print(f"{terminal(changes)}: the same bytes are not to be expected")
    record = {"width": config.record["width"]}
    RunFolder.open(settings, device=device, texts=lambda: texts, record=record).close()
    with Progress(settings.search.generations) as report:
        driver.evolve([settings], report=report, as_begun=True)


def _compare(one: Path, other: Path) -> int:
    """Print a line for each file of results that the first one has; 0 if all are the same."""
    before, now = _files(one), _files(other)
    differing = 0
    for name in sorted(before):
        words = _difference(name, before[name], now[name]) if name in now else "not in the repeated run"
        differing += not words.startswith("same")
        print(f"{terminal(name):40} {words}")
    if further := len(now.keys() - before.keys()):  # archives keep few solutions
        print(f"{further} further files are only in the repeated run")
    print("it came to the same" if not differing else f"{differing} files differ", flush=True)
    return _NOT_MATCHED if differing else 0


def _files(folder: Path) -> dict[str, Path]:
    """The files of the results by name. Raises InputError if one of them is a link or the like."""
    from slcs2_jax.results.run_folder import CHECKPOINT, GENERATIONS, GRAMMAR, KNOWLEDGE, SUMMARY
    from slcs2_jax.results.saved import SOLUTIONS

    names = [name for name in (CHECKPOINT, GENERATIONS, GRAMMAR, KNOWLEDGE, SUMMARY) if present(folder / name)]
    solutions = names_in(folder / SOLUTIONS, inside=folder)
    names += [f"{SOLUTIONS}/{name}" for name in solutions if Path(name).suffix in (".npz", ".txt")]
    for name in names:
        _read(folder / name, 0, folder)
    return {name: folder / name for name in names}


def _read(file: Path, most: int, folder: Path) -> bytes:
    """The first `most` bytes of a file in a folder. Raises InputError, StorageError."""
    try:
        with storing(file, "read"), reading(file, _LARGEST, inside=folder) as content:
            return content.read(most)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def _difference(name: str, before: Path, now: Path) -> str:
    new = now.read_bytes()  # we have written it
    old = _read(before, len(new) + 1, before.parents[name.count("/")])
    gone: list[str] = []
    if name.endswith(".jsonl"):
        new, gone = _as_kept(old, new)
    left_out = f", but for {', '.join(gone)}, which is not there" if gone else ""
    return f"same{left_out}" if old == new else "DIFFERS" + _where(name, old, new)


def _as_kept(before: bytes, now: bytes) -> tuple[bytes, list[str]]:
    """The rows now without the columns that the first row before has not; and which these are."""
    from slcs2_jax.results.rows import parse_row, row_line

    try:
        kept = parse_row(before.partition(b"\n")[0])
    except InputError:  # a damaged row: it differs
        return now, []
    rows = [parse_row(line) for line in now.splitlines()]
    gone = [column for column in rows[0] if column not in kept]
    if not gone:
        return now, []
    thin = ({column: value for column, value in row.items() if column not in gone} for row in rows)
    return b"".join(map(row_line, thin)), gone


def _where(name: str, before: bytes, now: bytes) -> str:
    if not name.endswith(".jsonl"):
        return ""
    pairs = zip(before.splitlines(), now.splitlines(), strict=False)
    first = next((line for line, (old, new) in enumerate(pairs, start=1) if old != new), None)
    return "" if first is None else f", first in line {first}"
