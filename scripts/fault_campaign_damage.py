"""Damage the files of run folders at random places: is everything detected, or harmless?"""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import fault_campaign_files as files
from fault_campaign_kills import results

from slcs2_jax.config import Checkpoint, Compute, InputError, Knowledge, Rules, Search, Settings, Swarm, World
from slcs2_jax.results import FinishedRun, Quiet, read_run
from slcs2_jax.results.sweep import SWEEP, runs_below, write_sweep

UNREAD = (".txt", "lock")  # written for people, read by no command


@dataclass
class Figures:
    """What became of damaged files; `believed` and `tracebacks` must be empty."""

    detected: int = 0
    harmless: int = 0
    believed: list[str] = field(default_factory=list)
    tracebacks: list[str] = field(default_factory=list)


def settings(run_dir: Path, generations: int = 4) -> Settings:
    """A run that takes less than a second."""
    return Settings(
        world=World(distance=120.0, time_limit=60),
        swarm=Swarm(agents=3, packets=3),
        rules=Rules(rules=14),
        knowledge=Knowledge(mode="reflex"),
        search=Search(generations=generations, fresh_deployments=2),
        compute=Compute(devices=1, chunk=20),
        checkpoint=Checkpoint(generations=1, seconds=None),
        instances=2,
        run_dir=str(run_dir),
    )


class Interrupted(BaseException):
    """Stops a run in the middle."""


class _Stop(Quiet):
    def generation(self, *, done, best, evaluations, env_steps) -> None:  # type: ignore[no-untyped-def]
        if min(done) >= 2:
            raise Interrupted


def damage(count: int, folder: Path, *, seed: int = 0) -> Figures:
    """So many damaged files of an unfinished run that then goes on, of a finished one that is read and extended, and of
    all else that is read (`fault_campaign_files`)."""
    from slcs2_jax.running import driver

    chance, figures = random.Random(seed), Figures()
    finished, longer, begun = (folder / name for name in ("finished", "longer", "begun"))
    driver.evolve([settings(finished), settings(longer, 5)])
    try:
        driver.evolve([settings(begun)], report=_Stop())
    except Interrupted:
        write_sweep(begun, [settings(begun)])
    plain = read_all(finished)
    expected, extended = results(finished), results(longer)
    files.write_files(folder / "files")
    said = {name: read(folder / "files" / name) for name, read in files.READERS.items()}

    def reads(copy: Path) -> bool:
        return read_all(copy) == plain

    def goes_on(copy: Path) -> bool:
        _resume(copy, 4)
        return _same(results(copy), expected)

    def goes_further(copy: Path) -> bool:
        _resume(copy, 5)
        return _same(results(copy), extended)

    def is_read(copy: Path, name: str) -> bool:
        found = files.READERS[name](copy / name)
        # of a transfer a last line cut short is none, and computed again
        return found == said[name] or (name == files.DEPLOYMENTS and found.items() <= said[name].items())

    trials: list[tuple[Path, Callable[[Path], bool]]] = [(finished, reads), (begun, goes_on), (finished, goes_further)]
    for number in range(count):
        # most are read: that takes a hundredth of the time of going on
        source, check = trials[0] if number % 10 else chance.choice(trials[1:])
        if other := number % 2:
            source = folder / "files"
        copy = folder / "copy"
        shutil.copytree(source, copy)
        if other:
            name = chance.choice(sorted(files.READERS))
            file, check = copy / name, partial(is_read, name=name)
        else:
            file = chance.choice(sorted(path for path in copy.rglob("*") if path.is_file()))
        data = file.read_bytes()
        kind, changed = chance.choice(list(_changes(data, chance)))
        file.write_bytes(changed)
        if changed != data:
            then = "is read" if other else check.__name__
            _judge(figures, f"{kind} of {file.relative_to(copy)} then {then}", partial(check, copy))
        shutil.rmtree(copy)
    return figures


def _changes(data: bytes, chance: random.Random) -> Iterator[tuple[str, bytes]]:
    yield "truncation", data[: chance.randrange(max(1, len(data)))]
    if data:
        place = chance.randrange(len(data))
        yield f"bit flip at {place}", data[:place] + bytes([data[place] ^ 1 << chance.randrange(8)]) + data[place + 1 :]
        length = min(len(data) - place, 64)
        yield f"zeros at {place}", data[:place] + bytes(length) + data[place + length :]


def _judge(figures: Figures, what: str, check: Callable[[], bool]) -> None:
    try:
        right = check()
    except InputError as error:
        figures.detected += 1
        if "\n" in str(error) or "copy" not in str(error):
            figures.believed.append(f"{what}: its error names no file: {error}")
    except Exception as error:
        figures.tracebacks.append(f"{what}: {type(error).__name__}: {error}")
    else:
        if right:
            figures.harmless += 1
        else:
            figures.believed.append(what)


def read_all(folder: Path) -> object:
    """Everything that a run folder says, in a form that can be compared."""
    run = read_run(folder)
    return run.settings, run.record, run.rows, run.summary, run.timing, [_solution(one) for one in _solutions(run)]


def _solutions(run: FinishedRun) -> Iterator[object]:
    for instance in range(run.settings.instances):
        yield run.best(instance)
        yield from run.members(instance)


def _solution(one: object) -> list[object]:
    values = vars(one).copy()
    rules = values.pop("rules")
    arrays = {"mask": rules.mask, "action": rules.action} | values
    return [(name, value.tobytes() if hasattr(value, "tobytes") else value) for name, value in arrays.items()]


def _resume(folder: Path, generations: int) -> None:
    from slcs2_jax.running import driver

    found, _ = runs_below(folder)
    driver.evolve([replace(one, search=replace(one.search, generations=generations)) for one in found])


def _same(found: dict[str, bytes], expected: dict[str, bytes]) -> bool:
    """Equal but for what no command reads, and for what is written again only when the run is."""
    names = found.keys() | expected.keys()
    return all(found.get(name) == expected.get(name) or name.endswith(UNREAD) or name == SWEEP for name in names)
