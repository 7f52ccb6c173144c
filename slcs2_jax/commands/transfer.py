"""slcs2 transfer: what winners are worth in worlds that they have not seen."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.changes import folder_and_changes
from slcs2_jax.commands.policies import policy_named
from slcs2_jax.commands.report import print_passed
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.config.worlds import Kind
    from slcs2_jax.results import FinishedRun
    from slcs2_jax.running.transfer import Traveller
    from slcs2_jax.study.transfer import Source

TAKES_SETTINGS = False
HELP = """\
slcs2 transfer FOLDER [FOLDER ...] [setting=value ...]: the winners of all runs in these folders and below them,
deployed in worlds that they have not seen, beside the designed behaviour: a matrix of means and a heat map

  worlds=LIST           where: [open/short/0..29, jammed/short/0..29]; without it 30 of each environment, of the ranges
                        that the runs have, from seed 9000000. No run may have evolved in one of them
  deployments=1         of each winner in each world
  policy=designed       the behaviour beside them, as in slcs2 evaluate
  out=FOLDER/transfer   where to (the first folder's): deployments.jsonl (every deployment), transfer.md, matrix.csv,
                        contests.csv, tables.tex, transfer.png, transfer.svg
  compute.devices=N     how many devices are used
Winners of a run with search.inherit_quality are deployed twice: with the quality that they inherited, and without.
Winners of runs through many worlds (worlds=) are generalists, the others specialists of their kind of world.
What is in deployments.jsonl is not computed again: repeated, the command goes on where it was interrupted.
Exit code: 0 done, 2 bad input (one line says what), 130 interrupted.
"""
OPTIONS = ("worlds", "deployments", "policy", "out", "compute.devices", "compute.cache")
TRANSFER = "transfer"  # folder below that of the runs
_UNSEEN, _OF_EACH = 9_000_000, 30  # first seed and number of the worlds that are taken unless others are named
_MOST_DEPLOYMENTS = 100
_LARGEST = 2**30  # bytes of a solution's file

Label = tuple[str, str, str, str]  # name, role, home and quality of a row


def run(arguments: list[str]) -> int:
    """Deploy the winners everywhere, and write what it comes to."""
    others = [argument for argument in arguments if "=" not in argument and not argument.startswith("-")][1:]
    rest = [argument for argument in arguments if argument not in others]
    name, given = folder_and_changes("transfer", rest, OPTIONS)
    try:
        import slcs2_jax.study.transfer  # noqa: F401 (before hours of computing)
    except ImportError as error:
        raise InputError(
            f"transfer: {error.name} is not installed; accepted is an installation with slcs2_jax[analysis]"
        ) from None
    deployments = given.get("deployments", 1)
    if type(deployments) is not int or not 1 <= deployments <= _MOST_DEPLOYMENTS:
        raise refuse("deployments", deployments, f"a whole number from 1 to {_MOST_DEPLOYMENTS}")
    folder = Path(name)
    passed: list[str] = []
    runs = [run for place in dict.fromkeys([folder, *map(Path, others)]) for run in _runs(place, passed)]
    kinds = _kinds(given.get("worlds"), runs)
    out = Path(str(given["out"])) if given.get("out") else None
    print_passed(passed)
    from slcs2_jax import runtime
    from slcs2_jax.config import Compute
    from slcs2_jax.results import Progress
    from slcs2_jax.results.files import make_folder, storing
    from slcs2_jax.results.lock import FolderLock
    from slcs2_jax.running.transfer import travel

    compute = Compute(devices=given.get("compute.devices"), cache=given.get("compute.cache", True))
    rows = _rows(runs, str(given.get("policy", "designed")), compute)
    if out is None:
        out = folder / TRANSFER
        make_folder(out, inside=folder)
    else:
        with storing(out, "made"):
            out.mkdir(parents=True, exist_ok=True)
    runtime.configure(compute)
    with FolderLock(out), Progress(deployments, label="deployment") as report:
        travellers = [one for _, several in rows for one in several]
        found = iter(travel(travellers, kinds, deployments=deployments, folder=out, report=report))
        sources = [_source(row, [next(found) for _ in several], kinds) for row, several in rows]
        _write(out, sources)
    return 0


def _runs(folder: Path, passed: list[str]) -> list[FinishedRun]:
    from slcs2_jax.results import read_run
    from slcs2_jax.results.run_config import read_config
    from slcs2_jax.results.run_folder import folders_with_config

    if not folder.is_dir():
        raise refuse("folder", str(folder), "a folder with runs of slcs2")
    found = [read_run(place) for place in folders_with_config(folder, passed) if read_config(place).evolves]
    passed += [f"{run.path}: has not ended" for run in found if run.summary is None]
    ended = [run for run in found if run.summary is not None]
    if not ended:
        raise refuse("folder", str(folder), "a folder with finished runs of evolution")
    return ended


def _kinds(given: Any, runs: Sequence[FinishedRun]) -> tuple[Kind, ...]:
    """Where to deploy. Raises InputError for a list that is none, or a world in which a run evolved."""
    from slcs2_jax.config.model import ENVIRONMENTS
    from slcs2_jax.config.worlds import ACCEPTED, kinds_of, worlds_of
    from slcs2_jax.results.arm import cell_of

    if given is None:
        lengths = {its.world.range for run in runs for its in _settings_of(run.settings)}
        last = _UNSEEN + _OF_EACH - 1
        given = [f"{one}/{length}/{_UNSEEN}..{last}" for length in sorted(lengths)[::-1] for one in ENVIRONMENTS]
    if not isinstance(given, list) or not given or not all(isinstance(entry, str) for entry in given):
        raise refuse("worlds", given, ACCEPTED)
    kinds = kinds_of(given)
    wanted = {(kind.environment, kind.range, seed) for kind in kinds for seed in kind.seeds}
    for run in runs:
        settings = run.settings
        instances = [(settings, settings.seed + number) for number in range(settings.instances)]
        for its, seed in [(its, seed) for _, its, seed in worlds_of(settings)] or instances:
            cell = cell_of(its)
            if {(cell.environment, cell.range, seed), (cell.environment, None, seed)} & wanted:
                raise refuse("worlds", f"{cell.environment}/{cell.range}/{seed}", f"worlds not seen in {run.path}")
    return kinds


def _rows(runs: Sequence[FinishedRun], policy: str, compute: Any) -> list[tuple[Label, list[Traveller]]]:
    """Name, role, home and quality of every row, and what is deployed for it; behaviours last."""
    from slcs2_jax.config.door import read_file
    from slcs2_jax.config.worlds import worlds_of
    from slcs2_jax.results.arm import arm_of, arm_title, cell_of
    from slcs2_jax.results.saved import SOLUTIONS
    from slcs2_jax.running.transfer import Traveller, deployed_in

    found: dict[Label, list[Traveller]] = {}
    arms = [arm_of(dataclasses.replace(run.settings, worlds=())) for run in runs]
    for run, arm in zip(runs, arms, strict=True):
        settings, cell = run.settings, cell_of(run.settings)
        worlds = worlds_of(settings)
        name = f"{len(worlds)} worlds" if worlds else cell.title
        if len({*arms}) > 1:
            name += f", {arm_title(arm)}"
        role, home = ("generalist", "") if worlds else ("specialist", f"{cell.environment}/{cell.range}")
        for instance in range(settings.instances):
            best = run.best(instance)
            file = run.path / SOLUTIONS / f"instance_{instance:03d}_best.npz"
            digest = hashlib.sha256(read_file(file, _LARGEST, inside=run.path)).hexdigest()
            inherited = best.rules.quality is not None
            for quality in ("kept", "forgotten") if inherited else ("",):
                one = best.forgetful() if quality == "forgotten" else best
                traveller = Traveller(
                    policy=one, content=f"{digest} {quality}", settings=deployed_in(settings, compute)
                )
                found.setdefault((name, role, home, quality), []).append(traveller)
    named = policy_named(policy)
    base = deployed_in(runs[0].settings, compute)
    behaviour = Traveller(policy=named.policy, content=f"policy {named.title} {named.content}", settings=base)
    order = {"specialist": 0, "generalist": 1}
    rows = sorted(found.items(), key=lambda row: order[row[0][1]])
    return [*rows, ((named.title, "behaviour", "", ""), [behaviour])]


def _settings_of(settings: Settings) -> list[Settings]:
    """Of the worlds in which a run evolved, but for seeds."""
    from slcs2_jax.config.worlds import worlds_of

    return [its for _, its, _ in worlds_of(settings)] or [settings]


def _source(row: Label, winners: Sequence[Sequence[Sequence[float]]], kinds: Sequence[Kind]) -> Source:
    import numpy as np

    from slcs2_jax.study.transfer import Source, names_of

    name, role, home, quality = row
    fitness: Mapping[str, Any] = {
        column: np.array(
            [
                [one for kind, own in zip(kinds, winner, strict=True) if kind.name == column for one in own]
                for winner in winners
            ]
        )
        for column in names_of(kinds)
    }
    return Source(name, role, home, quality, fitness)


def _write(out: Path, sources: Sequence[Source]) -> None:
    """Tables and heat map; the matrix is printed, too."""
    from slcs2_jax.results.files import write_text
    from slcs2_jax.study.transfer import contests_table, matrix_table

    matrix, contests = matrix_table(sources), contests_table(sources)
    write_text(out / "matrix.csv", matrix.csv())
    write_text(out / "contests.csv", contests.csv())
    write_text(out / "tables.tex", "\n".join([matrix.latex(), contests.latex()]))
    picture = ""
    try:
        from slcs2_jax.looking import drawing
        from slcs2_jax.study.transfer_figure import transfer_figure
    except ImportError:
        print("no heat map: it needs matplotlib, the extra plot")
    else:
        drawing.save(lambda: transfer_figure(sources), out / "transfer")
        picture = "\n![Mean fitness of every source in every kind of world](transfer.png)\n"
    write_text(out / "transfer.md", f"# Transfer\n\n{matrix.markdown()}{picture}\n{contests.markdown()}")
    width = max(len(one.title) for one in sources)
    print(" " * width + "".join(f"{name:>20}" for name in matrix.header[4:]))
    for one, row in zip(sources, matrix.rows, strict=True):
        print(f"{terminal(one.title):{width}}" + "".join(f"{value:>20.3f}" for value in row[4:]))
    print(f"transfer {terminal(str(out / 'transfer.md'))}", flush=True)
