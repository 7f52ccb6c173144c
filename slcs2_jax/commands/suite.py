"""slcs2 suite: the benchmark's worlds and entries: listed, trained, evaluated in the test worlds, put into a table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.looked_at import one_of, told_apart
from slcs2_jax.config import plugins
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config import Compute
    from slcs2_jax.config.compose import Job
    from slcs2_jax.suite.entries import Entry
    from slcs2_jax.suite.table import Table
    from slcs2_jax.suite.worlds import Suite, SuiteWorld

TAKES_SETTINGS = False
HELP = """\
slcs2 suite list: the frozen worlds, and what takes part
slcs2 suite train ENTRY [option=value ...]: train an entry on train seeds, choose by validation seeds, keep the artefact
slcs2 suite evaluate ENTRY [option=value ...]: deploy it in the test worlds, and print its row beside the others'
slcs2 suite table [option=value ...]: rows of all entries that were evaluated; out=FOLDER for a page, Markdown and CSV

ENTRY is one of slcs2 suite list, or yours: a decision list (.txt), a training by its settings (.yaml), a saved solution
or policy (.npz), or the name of a policy that plugins=[my_module] brings; several with commas between them.

  world=A,B          some of the worlds; all by default
  run_dir=runs/suite what is trained and evaluated is kept there, and not computed again
  trainings=N        train, evaluate: so many for each world; by default as the suite says
  episodes=N         train: in place of the budget, for a trial in a run_dir of its own
  split=test         evaluate, table: test, which is looked at once, or validation, by which entries are tuned
  seeds=N            evaluate, table: the first so many worlds of each kind
  deployments=N      evaluate: in each world; by default as the suite says
  out=FOLDER         table: a folder that exists
  replays=off        table: on: the page replays the best entry of each field in each kind of worlds
  compute.*          how the machine is used, as in slcs2 evolve
  hydra/launcher=... train, evaluate: a job for each world (docs/cluster.md)
Interrupted, the same command goes on. The protocol is docs/suite.md.
Exit code: 0 done, 1 the disk refused, 2 bad input (one line says what), 130 or 143 interrupted.
"""
_DEFAULTS: dict[str, Any] = {
    "world": None, "run_dir": "runs/suite", "split": "test", "trainings": None, "episodes": None, "seeds": None,
    "deployments": None, "entry": None, "out": None, "replays": False,
}  # fmt: skip
OPTIONS = tuple(_DEFAULTS)
_ACTIONS = {
    "list": (),
    "train": ("world", "run_dir", "trainings", "episodes"),
    "evaluate": ("world", "run_dir", "split", "trainings", "seeds", "deployments"),
    "table": ("world", "run_dir", "split", "seeds", "entry", "out", "replays"),
}
_KINDS = "kinds"  # in the configuration: names of kinds of worlds; `world` is that of a group of settings
_COLUMNS = (0, 2, 3, 4, 5, 6, 7, 9, 10, 11, 13)  # of a row, on a terminal


def run(arguments: list[str]) -> int:
    """Do what the arguments say."""
    subjects, options, others = told_apart([one for one in arguments if one not in ("-m", "--multirun")], _DEFAULTS)
    action = subjects.pop(0) if subjects else ""
    if action not in _ACTIONS:
        raise refuse("suite", action, "one of " + ", ".join(_ACTIONS) + " (slcs2 suite --help)")
    for name in OPTIONS:
        if name not in _ACTIONS[action] and options[name] != _DEFAULTS[name]:
            raise refuse("option", name, "one of " + (", ".join(_ACTIONS[action]) or "none"))
    wanted = 1 if action in ("train", "evaluate") else 0
    if len(subjects) != wanted or (others and not wanted):
        said = " ENTRY" if wanted else ""
        raise InputError(f"suite: accepted is slcs2 suite {action}{said} [option=value ...] (slcs2 suite --help)")
    for name in others:
        if not name.startswith(("compute.", "hydra/launcher=", "hydra.launcher.")):
            raise refuse(
                "setting", name.partition("=")[0], "an option, compute.* or hydra/launcher: the worlds are frozen"
            )
    one_of("split", options["split"], ("test", "validation"))
    if action in ("evaluate", "table"):
        _check_installed()
    from slcs2_jax.suite.worlds import load_suite

    suite = load_suite()
    if action == "list":
        print(_listing(suite), end="", flush=True)
    elif action == "table":
        _table(suite, options)
    else:
        _compute(suite, action, subjects[0], options, others)
    return 0


def _check_installed() -> None:
    """Raise InputError without what the table's statistics need."""
    try:
        import slcs2_jax.suite.statistics  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"suite: {error.name} is not installed; accepted is an installation with slcs2_jax[analysis]"
        ) from None


def _listing(suite: Suite) -> str:
    """Worlds and entries."""
    from slcs2_jax.suite.entries import shipped

    lines = [f"{suite.version}: {suite.deployments} deployments in each test world", "", "worlds"]
    for world in suite.worlds.values():
        counts = ", ".join(f"{len(world.seeds_of(split))} {split}" for split in world.seeds)
        lines.append(
            f"  {world.name:18} {world.title}; seeds: {counts}; {world.trainings} trainings of {world.env_steps:,} "
            f"env-steps, {world.episodes} episodes; {world.sha256[:12]}"
        )
    lines += ["", "entries"]
    lines += [f"  {one.name:18} {one.field:10} {one.title}: {one.about}" for one in shipped().values()]
    return "\n".join([*lines, "", "What a solution may know", "  " + suite.knows, ""])


def _compute(suite: Suite, action: str, subject: str, options: dict[str, Any], others: list[str]) -> None:
    """Train or evaluate: a job for each kind of world, all in one call but with another launcher."""
    from slcs2_jax.config import Settings, settings_from
    from slcs2_jax.config.command_line import CommandLine
    from slcs2_jax.config.compose import run_hydra
    from slcs2_jax.config.settings import SECTIONS
    from slcs2_jax.config.store import Primary
    from slcs2_jax.suite.entries import chosen

    entries, worlds = chosen(subject), suite.chosen(options["world"])
    counts = {name: _count(name, options[name]) for name in ("trainings", "episodes", "seeds", "deployments")}
    root = Path(options["run_dir"])

    def together(jobs: list[Job]) -> list[float]:
        compute = settings_from({"compute": jobs[0].config["compute"]}).compute
        here = [suite.world(str(job.config[_KINDS])) for job in jobs]
        if action == "train":
            _train(entries, here, root, compute, counts)
        else:
            _evaluate(suite, entries, here, root, compute, counts, options["split"])
        return [0.0] * len(jobs)

    primary = Primary(
        name="suite",
        settings=Settings(),
        choices={},
        own={_KINDS: None},
        left_out=[name for name in SECTIONS if name != "compute"],
    )
    brought = [f"{plugins.SETTING}=[{','.join(plugins.loaded())}]"] if plugins.loaded() else []
    every = f"{_KINDS}={','.join(world.name for world in worlds)}"
    run_hydra(primary, CommandLine((every, *brought, *others), sweep=True), together)
    if action == "evaluate":
        _print(_collected(suite, root, worlds, counts["seeds"], options["split"]), [entry.name for entry in entries])


def _count(name: str, said: str | None) -> int | None:
    if said is None:
        return None
    if not (said.isascii() and said.isdecimal() and 0 < int(said) <= 10**6):
        raise refuse(name, said, "a whole number from 1")
    return int(said)


def _train(
    entries: list[Entry], worlds: list[SuiteWorld], root: Path, compute: Compute, counts: dict[str, int | None]
) -> None:
    from slcs2_jax.results import Progress
    from slcs2_jax.suite.training import made, plan, train

    limits = {name: counts[name] for name in ("trainings", "episodes")}
    trainings = [one for entry in entries for one in plan(entry, worlds, root, compute=compute, **limits)]
    going = [one for one in trainings if not made(one)]
    searches = [one for one in going if not one.entry.algorithm]
    found = []
    if searches:
        most = max(one.settings.search.generations for one in searches)
        with Progress(most, afterwards="now the validation worlds") as report:
            found += train(searches, report)
    for entry in entries:
        for world in worlds:
            here = [one for one in going if entry.algorithm and one.entry is entry and one.world is world]
            if here:
                budgets = sum(one.budget for one in here)
                with Progress(budgets, label=f"{entry.name}, {world.name}: env-step") as report:
                    found += train(here, report)
    for path in found:
        print(f"artefact {terminal(str(path))}")
    print(f"{len(found)} trained, {len(trainings) - len(found)} were there", flush=True)


def _evaluate(
    suite: Suite,
    entries: list[Entry],
    worlds: list[SuiteWorld],
    root: Path,
    compute: Compute,
    counts: dict[str, int | None],
    split: str,
) -> None:
    from slcs2_jax.results import Progress
    from slcs2_jax.suite.evaluation import evaluate

    deployments = counts["deployments"] or suite.deployments
    for entry in entries:
        for world in worlds:
            with Progress(deployments, label=f"{entry.name}, {world.name}: deployment") as report:
                limits = {name: counts[name] for name in ("seeds", "trainings")}
                evaluate(
                    entry, world, root, compute=compute, deployments=deployments, report=report, split=split, **limits
                )


def _collected(
    suite: Suite, root: Path, worlds: list[SuiteWorld], seeds: int | None, split: str, only: tuple[str, ...] = ()
) -> Table:
    from slcs2_jax.suite.measured import shipped_root
    from slcs2_jax.suite.table import collect

    return collect(suite, (root, shipped_root()), worlds, only=only, seeds=seeds, split=split)


def _print(table: Table, marked: list[str] | None = None) -> None:
    """The rows of entries that were in all of the kinds of worlds that the table has, the fittest first."""
    from slcs2_jax.suite.rows import HEADER, as_text, printed, row, winners

    names = [world.name for world in table.worlds]
    over_all = [entry for entry in table.entries if table.common_worlds(entry) == names]
    rows = {entry: row(table, entry, names) for entry in over_all}
    order = sorted(over_all, key=lambda entry: -rows[entry]["fitness"].value)
    print(f"{table.suite.version}, {len(names)} of {len(table.suite.worlds)} kinds of worlds")
    lines = []
    for entry in order:
        cells = [printed(value) for value in rows[entry].values()]
        cells[0] = f"> {cells[0]}" if entry in (marked or ()) else cells[0]
        lines.append([cells[at] for at in _COLUMNS])
    print(as_text([HEADER[at] for at in _COLUMNS], lines))
    for entry in (*(marked or ()), *table.entries):
        if entry not in over_all and marked is None:
            there = len(table.common_worlds(entry))
            print(f"{terminal(table.entries[entry])}: in {there} of these kinds of worlds alone, so no row")
    if marked is None:
        best = winners(table)
        print()
        print(as_text(list(best[0]), [[printed(value) for value in one.values()] for one in best]))
    print(end="", flush=True)


def _table(suite: Suite, options: dict[str, Any]) -> None:
    from slcs2_jax.suite.entries import chosen
    from slcs2_jax.suite.page import write_all

    out = options["out"]
    if out is not None and not Path(out).is_dir():
        raise refuse("out", out, "a folder that exists")
    only = () if options["entry"] is None else tuple(entry.name for entry in chosen(options["entry"]))
    seeds, root = _count("seeds", options["seeds"]), Path(options["run_dir"])
    table = _collected(suite, root, suite.chosen(options["world"]), seeds, options["split"], only)
    if not table.entries:
        raise InputError(f"run_dir={terminal(str(root))}: holds no results; slcs2 suite evaluate ENTRY makes them")
    _print(table)
    if out is not None:
        replays: Any = ()
        if options["replays"]:
            from slcs2_jax.config import Compute
            from slcs2_jax.suite.measured import shipped_root
            from slcs2_jax.suite.shown import shown

            replays = shown(table, (root, shipped_root()), Compute())
        for path in write_all(Path(out), table, replays):
            print(f"written {terminal(str(path))}", flush=True)
