"""The folder of one run while it is made. What is in it is replaced whole or added to, never damaged.

config.yaml, grammar.bnf, perhaps knowledge.txt and world.yaml, generations.jsonl, checkpoint.npz, solutions/,
timing.json and, last of all, summary.json.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from slcs2_jax.config import InputError, Settings, plugins
from slcs2_jax.config.door import folders_below, present, read_file, telling_damage
from slcs2_jax.config.field import show
from slcs2_jax.config.worlds import kinds_of
from slcs2_jax.grammar.source import MAX_BYTES
from slcs2_jax.results.archive import Limits, read_archive, write_archive
from slcs2_jax.results.documents import write_document
from slcs2_jax.results.files import (
    delete,
    delete_others,
    make_folder,
    remove_leftovers,
    storing,
    sync,
    write_whole,
)
from slcs2_jax.results.lock import FolderLock
from slcs2_jax.results.rows import MOST_ROWS, append_rows, cut_rows, sort_rows
from slcs2_jax.results.run_config import (
    CONFIG,
    RunConfig,
    check_same,
    check_writable,
    new_record,
    read_config,
    write_config,
)
from slcs2_jax.results.saved import SOLUTIONS, SavedSolution

WORLD = "world.yaml"
GRAMMAR, KNOWLEDGE, GENERATIONS, CHECKPOINT, TIMING, SUMMARY = (
    "grammar.bnf",
    "knowledge.txt",
    "generations.jsonl",
    "checkpoint.npz",
    "timing.json",
    "summary.json",
)
# Before config.yaml a folder holds no run: these may be left of one that was killed while it started.
_STARTED = (CONFIG, GENERATIONS, CHECKPOINT, SOLUTIONS, TIMING, SUMMARY)
_SUMS = {GRAMMAR: "grammar_crc", KNOWLEDGE: "knowledge_crc"}  # in the record: of the texts that a folder keeps
CHECKPOINT_FORMAT = "slcs2_jax checkpoint 3"
SUMMARY_VERSION = TIMING_VERSION = 1


def folders_with_config(root: Path, passed: list[str] | None = None) -> Iterator[Path]:
    """The folders at and below `root` that hold a config.yaml, in order; links are not followed.

    `passed` gets a line for each folder that was passed over. Raises InputError for more folders than any study has.
    """
    return (folder for folder in folders_below(root, passed) if present(folder / CONFIG))


def check_free(path: str | Path) -> Path:
    """The folder as a Path if a new run may use it; raises InputError naming it otherwise. Makes nothing."""
    folder = check_writable(path)
    taken = [name for name in _STARTED if present(folder / name)]
    if taken:
        label = f"run_dir={show(str(path))}"
        raise InputError(f"{label}: already holds a run ({taken[0]}); accepted is a folder that is new or holds none")
    return folder


def check_usable(settings: Settings) -> RunConfig | None:
    """What the run folder holds if these settings can go on with it, None if it is free. Makes nothing.

    Raises InputError if it holds another run, naming the setting that differs, or a damaged one.
    """
    if settings.run_dir is None:
        raise InputError("run_dir=null: accepted is the path of a folder")
    folder = Path(settings.run_dir)
    if not present(folder / CONFIG):
        check_free(folder)
        return None
    found = read_config(folder)
    if not found.evolves:
        raise InputError(f"run_dir={show(settings.run_dir)}: already holds an evaluation; accepted is another folder")
    check_same(settings, found.settings, folder)
    return found


@dataclass
class RunFolder:
    """The folder of a run that is being written. With `open` it is locked until `close`."""

    path: Path
    config: RunConfig
    _lock: FolderLock | None = field(default=None, repr=False)

    @classmethod
    def create(
        cls, settings: Settings, *, device: str, record: Mapping[str, Any] | None = None, kind: str = "evaluate"
    ) -> RunFolder:
        """Make `settings.run_dir` and its config.yaml, which keeps `record` beside time, command, device and versions.

        Raises InputError if the folder holds a run or cannot be written, StorageError if the disk refuses.
        """
        if settings.run_dir is None:
            raise InputError("run_dir=null: accepted is the path of a folder")
        folder = check_free(settings.run_dir)
        with storing(folder, "made"):
            folder.mkdir(parents=True, exist_ok=True)
        config = RunConfig(settings, new_record(kind, device, {**(record or {}), **plugins.recorded(settings.plugins)}))
        write_world(folder, settings)
        write_config(folder, config)
        return cls(folder, config)

    @classmethod
    def open(
        cls, settings: Settings, *, device: str, texts: Callable[[], Mapping[str, str]], record: Mapping[str, Any]
    ) -> RunFolder:
        """Lock the folder of a run of evolution; make it if it is new, else go on with what it holds.

        A run that goes further than it did is noted in its config.yaml, and no longer counts as finished. Of a new
        one, `texts` gives by file names what the folder keeps: the grammar, and the list of knowledge if it has one.

        Raises InputError if another process works in it, or it holds another run or a damaged one; StorageError.
        """
        if settings.run_dir is None:
            raise InputError("run_dir=null: accepted is the path of a folder")
        folder = check_writable(settings.run_dir)
        with storing(folder, "made"):
            folder.mkdir(parents=True, exist_ok=True)
        lock = FolderLock(folder)
        try:
            remove_leftovers(folder)
            found = check_usable(settings)
            if found is None:
                sums = {}
                for name, text in texts().items():
                    sums[_SUMS[name]] = _write_text(folder / name, text)
                more = {**record, **sums, **plugins.recorded(settings.plugins)}
                found = RunConfig(settings, new_record("evolve", device, more))
                write_world(folder, settings)
                write_config(folder, found)
            elif found.settings.search.generations < settings.search.generations:
                search = replace(found.settings.search, generations=settings.search.generations)
                found = RunConfig(replace(found.settings, search=search), found.record)
                write_config(folder, found)
                delete(folder / SUMMARY)
        except BaseException:
            lock.release()
            raise
        return cls(folder, found, lock)

    def close(self) -> None:
        """Let go of the folder."""
        if self._lock is not None:
            self._lock.release()

    def append(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows (one per instance and generation) to generations.jsonl. Raises ValueError for NaN or infinity."""
        append_rows(self.path / GENERATIONS, rows)

    def cut_rows(self, generations: Sequence[int]) -> None:
        """Leave in generations.jsonl the rows of the first `generations[i]` generations of instance i alone."""
        file = self.path / GENERATIONS
        try:
            cut_rows(file, generations, most_rows(self.config.settings))
        except InputError as error:
            raise InputError(f"{file}: {error}; {_start_over(GENERATIONS, CHECKPOINT)}") from None

    def sort_rows(self) -> None:
        """Put generations.jsonl into the order of a run that has ended."""
        file = self.path / GENERATIONS
        try:
            sort_rows(file, most_rows(self.config.settings))
        except InputError as error:
            raise InputError(f"{file}: {error}; {_start_over(GENERATIONS, CHECKPOINT)}") from None

    def save_checkpoint(self, arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any]) -> None:
        """Replace checkpoint.npz, once the rows that it counts on are on the disk. Raises StorageError."""
        sync(self.path / GENERATIONS)
        write_archive(self.path / CHECKPOINT, CHECKPOINT_FORMAT, arrays, about, compressed=False)

    def load_checkpoint(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]] | None:
        """What save_checkpoint was given last, None before the first time. Raises InputError naming a damaged file."""
        file = self.path / CHECKPOINT
        if not present(file):
            return None
        try:
            with storing(file, "read"):
                return read_archive(file, CHECKPOINT_FORMAT, checkpoint_limits(self.config.settings))
        except InputError as error:
            raise self.bad_checkpoint(error) from None

    def bad_checkpoint(self, error: Exception) -> InputError:
        """What to say of a checkpoint that cannot be gone on from."""
        return InputError(f"{self.path / CHECKPOINT}: {show(str(error))}; {_start_over(CHECKPOINT)}")

    def read_grammar(self) -> str:
        """grammar.bnf as it was when the run was started. Raises InputError if it was changed since."""
        return read_grammar(self.path, self.config)

    def read_knowledge(self) -> str | None:
        """knowledge.txt as it was then; None for a run without knowledge. Raises InputError if it was changed since."""
        return read_knowledge(self.path, self.config)

    def save_best(self, instance: int, solution: SavedSolution) -> Path:
        """solutions/instance_000_best.npz and .txt; returns the .npz's path."""
        return self._save(f"instance_{instance:03d}_best", solution)

    def save_member(self, instance: int, member: int, solution: SavedSolution) -> Path:
        """solutions/instance_000_member_000.npz and .txt, one member of the final collection."""
        return self._save(f"instance_{instance:03d}_member_{member:03d}", solution)

    def _save(self, name: str, solution: SavedSolution) -> Path:
        path = self.path / SOLUTIONS / f"{name}.npz"
        make_folder(path.parent, inside=self.path)
        solution.save(path, inside=self.path)
        solution.save_text(path.with_suffix(".txt"), inside=self.path)
        return path

    def keep_solutions(self, kept: Iterable[Path]) -> None:
        """Delete every saved solution but these (.npz, and the .txt beside it): what a shorter run has left."""
        names = {path.with_suffix(end).name for path in kept for end in (".npz", ".txt")}
        delete_others(self.path / SOLUTIONS, names, (".npz", ".txt", ".tmp"), inside=self.path)

    def write_timing(self, timing: Mapping[str, Any]) -> None:
        """timing.json: how long the run took, which is no part of its results."""
        write_document(self.path / TIMING, "timing", TIMING_VERSION, timing)

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """summary.json, whole or not at all; its presence says that the run ended."""
        write_document(self.path / SUMMARY, "summary", SUMMARY_VERSION, summary)


def write_world(folder: Path, settings: Settings) -> None:
    """world.yaml, a copy of the world's file, if the run has one. config.yaml says the same; this is for people."""
    if settings.world.content is not None:
        data = settings.world.content.encode("utf-8")
        write_whole(folder / WORLD, lambda file: file.write(data))


def read_grammar(folder: Path, config: RunConfig) -> str:
    """The text of the grammar that a run was started with. Raises InputError naming the file if it was damaged."""
    return _read_text(folder, config, GRAMMAR, "grammar")


def read_knowledge(folder: Path, config: RunConfig) -> str | None:
    """The list of knowledge that a run was started with, None for none. Raises InputError if it was damaged."""
    if config.settings.knowledge.mode == "none":
        return None
    return _read_text(folder, config, KNOWLEDGE, "list of knowledge")


def _write_text(file: Path, text: str) -> str:
    """Keep a text with a run; returns its checksum."""
    data = text.encode("utf-8", "surrogatepass")
    write_whole(file, lambda out: out.write(data))
    return _crc(data)


def _read_text(folder: Path, config: RunConfig, name: str, what: str) -> str:
    file = folder / name
    try:
        with telling_damage("cannot be read"):
            data = read_file(file, 3 * MAX_BYTES)  # it is as long as that in letters
            if _crc(data) != config.record.get(_SUMS[name]):
                raise InputError("its checksum does not fit: it was damaged or changed by hand")
            return data.decode("utf-8", "surrogatepass")
    except InputError as error:
        raise InputError(
            f"{file}: not the {what} that the run was started with ({show(str(error))}); put it back, or start the "
            "run again in another folder"
        ) from None


def most_rows(settings: Settings) -> int:
    """How many lines generations.jsonl can have: a row for each instance and generation, and some cut short."""
    return min(MOST_ROWS, settings.search.generations * settings.instances + 64)


def checkpoint_limits(settings: Settings) -> Limits:
    """What a checkpoint of a run can hold: members, solutions asked for, their deployments, what searches keep."""
    size, search = settings.swarm.agents * settings.rules.rules, settings.search
    worlds = sum(len(kind.seeds) for kind in kinds_of(settings.worlds))
    finals = search.in_final(max(1, worlds)) if search.name in ("informed", "starters") else 0
    each = max(search.min_deployments, search.max_redeployments + 1, finals, worlds)
    deployments = max(search.batch * each, search.fresh_deployments + worlds)
    members, member = (
        search.generations + search.batch + 3,
        80 * size + 2**14 + 24 * (search.finalists.bit_length() * finals + worlds),
    )
    deployment = 20 * size + 8 * settings.swarm.agents + 64
    return Limits(
        entries=64 + 64 * settings.instances,
        size=2**20 + settings.instances * (2**20 + members * member + deployments * deployment),
        about=2**16 + (2**16 + 64 * search.batch) * settings.instances,
        compressed=False,
    )


def _crc(data: bytes) -> str:
    return f"{zlib.crc32(data):08x}"


def _start_over(*files: str) -> str:
    return f"delete {' and '.join(files)}, and slcs2 resume computes the run again from its start"
