"""Commands over hostile folders: each refused or read in little time and memory, and nothing outside touched.

Commands run in forks of a process that has imported the program and started nothing, one for each command and folder:

    python scripts/fault_campaign_hostile.py COUNT FOLDER SEED ONLY

prints the figures as JSON. ONLY: a regular expression that is found in FILE: KIND; STATE: COMMAND of those tried.
"""

from __future__ import annotations

import contextlib
import csv
import ctypes
import functools
import hashlib
import io
import json
import math
import os
import random
import re
import resource
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import fault_campaign_given as given
import fault_campaign_suite as suite
from fault_campaign_damage import Interrupted, _Stop, settings
from fault_campaign_folders import BEST, ODD_FOLDERS, Change, changes, entries, zeros

from slcs2_jax.results.sweep import SWEEP

SECONDS, MEMORY = 5.0, 2**30  # beyond what the command takes on a good folder
HANGS = 900.0  # s that nothing takes, however busy the machine is
SIZES = ("instances=1", "world.distance=120", "world.time_limit=60", "compute.devices=1", "compute.chunk=20")
_LIVE = re.compile(r"(?<!\\)<script|(?<!\\)\]\(java|\n# b")  # in Markdown
_LONG_AGO, _BEFORE = 10**9, 15 * 10**8  # s: when files outside were read and changed last


@dataclass
class Figures:
    """What became of hostile folders; `wrong` must be empty."""

    tried: int = 0
    refused: int = 0
    read: int = 0
    slowest: float = 0.0  # s of the processor, beyond the good folder
    largest: int = 0  # bytes, beyond the good folder
    wrong: list[str] = field(default_factory=list)


@dataclass
class Ended:
    """A command that has ended, with the processor's seconds and bytes that it took; code None: it had to be killed."""

    code: int | None
    said: str
    errors: str
    seconds: float
    memory: int


def commands(run: Path, scratch: Path) -> dict[str, list[str]]:
    """What is called, on a run or the folder above it."""
    return {
        "report": ["report", str(run), "replays=1"],
        "report of all": ["report", str(run.parent), "replays=0"],
        "replay": ["replay", str(run), "picture=paths", f"out={scratch}/paths.png"],
        "resume": ["resume", str(run)],
        "resume further": ["resume", str(run), "generations=5"],
        "repeat": ["repeat", str(run)],
        "rules": ["rules", str(run), "replay=off"],
        "watch": ["watch", str(run.parent), "once=on"],
        "evaluate": ["evaluate", f"solution={run / BEST}", *SIZES],
        "transfer": ["transfer", str(run), "worlds=[open/9000000]", "compute.devices=1"],
        "found": ["found", str(run.parent)],
    }


def _command(name: str, run: Path, scratch: Path) -> list[str]:
    """By its own name, or by that of the file that it is given."""
    return (commands(run, scratch) | given.commands(run, SIZES) | suite.commands(run, scratch))[name]


def _places(file: str) -> list[tuple[str, str]]:
    """The commands and folders that a file is tried with."""
    if file in (*suite.TRAINING, *suite.FOLDERS_TRAINING):
        return [("suite train", "training")]
    if file in (*suite.KEPT, *suite.FOLDERS_KEPT):
        return [(command, "trained") for command in suite.commands(Path(), Path())]
    called = [file] if file in given.FILES else commands(Path(), Path())
    return [(command, state) for command in called for state in ("finished", "begun")]


def hostile(count: int, folder: Path, *, seed: int = 0, only: str = "") -> Figures:
    """So many hostile folders, chosen by chance among all kinds, or those in whose description `only` is found, each
    under one command; then odd names of folders."""
    given.register_policy()
    suite.use_small_suite()
    figures, good = Figures(), folder / "good"
    good.mkdir(parents=True)
    for make in (_make, suite.make_suites):
        made = forked(functools.partial(make, good), folder, 600)
        if made.code != 0:
            raise RuntimeError(made.errors)
    bombs = {"zeros": zeros({f"x{number}": 2**28 for number in range(4)}), "many entries": entries()}
    trials = [(*change, *place) for change in changes(bombs) for place in _places(change[0])]
    trials = [trial for trial in trials if re.search(only, _what(trial[0], trial[1], *trial[3:]))]
    random.Random(seed).shuffle(trials)
    campaign, known = _Campaign(folder, figures), 0
    with contextlib.suppress(KeyboardInterrupt):  # what was found until then is said
        for trial in trials:
            if figures.tried == count:
                break
            campaign.attempt(*trial)
            last = figures.wrong[-1:] if len(figures.wrong) > known else ""
            known = len(figures.wrong)
            print(f"{figures.tried}/{count} hostile folders, {known} wrong {last}", file=sys.stderr, flush=True)
        campaign.odd_names()
    return figures


def _what(file: str, kind: str, command: str, state: str) -> str:
    return f"{file}: {kind}; {state}: {command}"


def _make(good: Path) -> int:
    """A finished run, whose winners were elsewhere, too, and one that was interrupted, each noted in a sweep."""
    from slcs2_jax.cli import main
    from slcs2_jax.results.sweep import write_sweep
    from slcs2_jax.running import driver

    driver.evolve([settings(good / "finished")])
    with contextlib.suppress(Interrupted):
        driver.evolve([settings(good / "begun")], report=_Stop())
    for name in ("finished", "begun"):
        given.write_given(good / name, settings(good / name))
        write_sweep(good / name, [settings(good / name)])
    return main(commands(good / "finished", good)["transfer"])


class _Campaign:
    def __init__(self, folder: Path, figures: Figures) -> None:
        self.folder, self.figures = folder, figures
        self._usual: dict[tuple[str, str], Ended] = {}

    def attempt(self, file: str, kind: str, change: Change, command: str, state: str) -> None:
        """One hostile folder under one command."""
        place = self.folder / "case"
        run, outside, scratch = place / "runs" / "one", place / "outside", place / "scratch"
        usual = self._on_a_good_folder(command, state)
        for copy in (run, outside):
            shutil.copytree(self.folder / "good" / state, copy)
        scratch.mkdir()
        try:
            change(run, run / file, outside)
        except (FileNotFoundError, PermissionError):  # such a run has no such file, or this is not root
            shutil.rmtree(place)
            return
        before = _snapshot(outside)
        ended = call(_command(command, run, scratch), self.folder, 10 * (usual.seconds + SECONDS))
        what = _what(file, kind, command, state)
        self._judge(what, ended, usual, place)
        but = file if kind == "another name of a good file" else ""
        if changed := _differences(before, _snapshot(outside), but):
            self.figures.wrong.append(f"{what}: touched outside: {changed}")
        shutil.rmtree(place)

    def _on_a_good_folder(self, command: str, state: str) -> Ended:
        """What the command takes, the second time: compiled programs are at hand then."""
        if (command, state) not in self._usual:
            for _ in range(2):
                place = self.folder / "usual"
                shutil.copytree(self.folder / "good" / state, place / "runs" / "one")
                ended = call(_command(command, place / "runs" / "one", place), self.folder, 600)
                shutil.rmtree(place)
            self._usual[command, state] = ended
        return self._usual[command, state]

    def _judge(self, what: str, ended: Ended, usual: Ended, place: Path) -> None:
        one, figures = ended, self.figures
        figures.tried += 1
        figures.slowest = max(figures.slowest, one.seconds - usual.seconds)
        figures.largest = max(figures.largest, one.memory - usual.memory)
        figures.refused += one.code in (1, 2)
        figures.read += one.code in (0, 3)
        lines = [line for line in one.errors.splitlines() if line.startswith("slcs2:")]
        found = []
        if one.code not in (0, 1, 2, 3):
            found.append(f"exit code {one.code}")
        if one.code in (1, 2) and (len(lines) != 1 or not any(str(part) in lines[0] for part in (place, "grammar"))):
            found.append(f"its line names no file: {lines}")
        if "Traceback" in one.errors or not _printable(one.said + one.errors):
            found.append(f"said {one.errors[-600:]!r}")
        if one.seconds > usual.seconds + SECONDS or one.memory > usual.memory + MEMORY:
            found.append(f"{one.seconds:.1f} s, {one.memory / 2**20:.0f} MB; usual are {usual.seconds:.1f}, "
                         f"{usual.memory / 2**20:.0f}")  # fmt: skip
        if found:
            figures.wrong.append(f"{what}: {'; '.join(found)}")

    def odd_names(self) -> None:
        """Folders and titles that are formulas, commands and markup, in all that is written of them."""
        place = self.folder / "names"
        for name in ODD_FOLDERS:
            for seed, below in enumerate(("a", name)):
                run = place / below / "run"
                shutil.copytree(self.folder / "good" / "finished", run)
                (run / SWEEP).unlink()
                _change_seed(run, 10 * seed)
            root = place / "suite"
            shutil.copytree(self.folder / "good" / "trained", root)
            _title_results(root, name)
            table = ["suite", "table", f"run_dir={root}", f"out={place / 'report'}"]
            for command in (["report", str(place), "replays=0"], ["watch", str(place), "once=on"], table):
                ended = call(command, self.folder, 120)
                self.figures.tried += 1
                self.figures.read += ended.code == 0
                if ended.code != 0 or not _printable(ended.said + ended.errors):
                    self.figures.wrong.append(f"{name!r}: {command[0]}: exit code {ended.code}: {ended.errors[-300:]}")
            self.figures.wrong += [f"{name!r}: {one}" for one in _markup(place / "report", name)]
            shutil.rmtree(place)


def _change_seed(run: Path, seed: int) -> None:
    """Runs that are compared are of different seeds."""
    import dataclasses

    from slcs2_jax.results.run_config import RunConfig, read_config, write_config

    config = read_config(run)
    record = {name: value for name, value in config.record.items() if name != "checksum"}
    write_config(run, RunConfig(dataclasses.replace(config.settings, seed=seed), record))


def _title_results(root: Path, title: str) -> None:
    """Results of an entry that is called so."""
    import dataclasses

    world = suite.small_suite().worlds[suite.WORLD]
    found = suite.measured.load(root, "mine", world)
    assert found is not None
    dataclasses.replace(found, title=title, field=title).save(root)


def _markup(report: Path, name: str) -> list[str]:
    """What a report says of such a name that is more than text."""
    found = []
    for file in report.glob("*.csv"):
        for row in csv.reader(io.StringIO(file.read_bytes().decode(), newline="")):
            found += [f"{file.name}: {cell!r}" for cell in row if cell[:1] in ("=", "+", "@", "\t", "\r", "\n")]
    for file in report.glob("*.tex"):
        found += [f"{file.name}: {name}" for one in ("\\input{", "$x^{") if one in file.read_text()]
    for file in report.glob("*.md"):
        text = file.read_text()
        found += [f"{file.name}: {one}" for one in _LIVE.findall(text)]
    return found


def call(arguments: list[str], folder: Path, seconds: float) -> Ended:
    """A command of the program, in a fork."""
    from slcs2_jax.cli import main

    return forked(lambda: main(arguments), folder, seconds)


def forked(act: Callable[[], int], folder: Path, seconds: float) -> Ended:
    """What becomes of a function in a process of its own, which is killed after so many seconds of the processor."""
    said, errors = folder / "stdout", folder / "stderr"
    start = time.monotonic()
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(seconds), math.ceil(seconds)))
        _child(act, said, errors)
    while True:
        done, status, usage = os.wait4(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > start + HANGS:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.01)
    return Ended(
        code=os.waitstatus_to_exitcode(status) if os.WIFEXITED(status) else None,
        said=said.read_text(errors="replace"),
        errors=errors.read_text(errors="replace"),
        seconds=usage.ru_utime + usage.ru_stime,
        memory=usage.ru_maxrss * 1024,
    )


def _child(act: Callable[[], int], said: Path, errors: Path) -> None:
    """Never returns."""
    code = 70
    try:
        for number, file in ((1, said), (2, errors)):
            os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), number)
        sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)  # noqa: SIM115
        _without_privileges()
        code = act()
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _without_privileges() -> None:
    """Root may read everything: it puts that down, so that permissions mean something."""
    if sys.platform == "linux" and os.geteuid() == 0:
        head, none = (ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()
        ctypes.CDLL(None).capset(head, none)


def _snapshot(outside: Path) -> dict[str, tuple[object, ...]]:
    """Everything outside, and when each file was last read; afterwards that is long ago again."""
    found = {}
    for path in sorted(outside.rglob("*")):
        state = path.lstat()
        content = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        read = int(state.st_atime) != _LONG_AGO
        found[str(path.relative_to(outside))] = (state.st_mode, state.st_size, content, read)
        if path.is_file():
            os.utime(path, (_LONG_AGO, _BEFORE))
    return found


def _differences(before: dict[str, tuple[object, ...]], after: dict[str, tuple[object, ...]], but: str) -> list[str]:
    """What was made, changed or read; a file that has another name in the run may be read by that."""
    found = [name for name in before.keys() | after.keys() if (name in before) != (name in after)]
    for name in before.keys() & after.keys():
        read = after[name][3] and name != but and _SHOWS_READING and Path(name).suffix
        if before[name][:3] != after[name][:3] or read:
            found.append(f"{name} ({'read' if before[name][:3] == after[name][:3] else 'changed'})")
    return found


def _shows_reading() -> bool:
    """Does the file system note when a file was read?"""
    import tempfile

    with tempfile.NamedTemporaryFile() as file:
        file.write(b"x")
        file.flush()
        os.utime(file.name, (_LONG_AGO, _BEFORE))
        Path(file.name).read_bytes()
        return int(os.stat(file.name).st_atime) != _LONG_AGO


_SHOWS_READING = _shows_reading()


def _printable(text: str) -> bool:
    return all(letter.isprintable() or letter in "\n\t" for letter in text)


if __name__ == "__main__":
    _count, _folder, _seed, _only = sys.argv[1:]
    print(json.dumps(asdict(hostile(int(_count), Path(_folder), seed=int(_seed), only=_only))))
