"""slcs2 found: what evolution found, over the winners of many runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands.looked_at import new_file, subject_and_options
from slcs2_jax.commands.report import print_passed
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.looking.findings import Findings

TAKES_SETTINGS = False
HELP = """\
slcs2 found FOLDER [out=FILE]: what the winners of all finished runs in FOLDER and below it do, worlds side by side:
which of the designer's rules are reflexes and which are switched off, what agents do and how much of it by learned
rules, which of these set a world apart, how packets travel

  out=FILE          a new file, Markdown; without it, on the terminal
  arm=NAME          of one kind of search alone, as its folder in an experiment is called: informed_150_episodes
Winners of one kind of search in one kind of world are told of together. slcs2 report RUN says the same of one run.
"""
_DEFAULTS: dict[str, Any] = {"out": None, "arm": None}
OPTIONS = tuple(_DEFAULTS)


def run(arguments: list[str]) -> int:
    """Read the winners, and tell of them."""
    folder, options = subject_and_options("found", arguments, _DEFAULTS)
    from slcs2_jax.looking.found_page import page

    out, passed = new_file(options["out"]), []  # type: ignore[var-annotated]
    told = page(_groups(Path(folder), options["arm"], passed))
    print_passed(passed)
    if out is None:
        print(terminal(told, lines=True), end="", flush=True)
    else:
        from slcs2_jax.results.files import write_text

        write_text(out, told)
        print(f"found {terminal(str(out))}", flush=True)
    return 0


def _groups(folder: Path, arm: str | None, passed: list[str]) -> dict[str, dict[str, list[Findings]]]:
    """The findings of every winner, by the search's arm and by world."""
    from slcs2_jax.looking.findings import findings
    from slcs2_jax.results import read_run
    from slcs2_jax.results.arm import CELLS, arm_of, arm_title, cell_of
    from slcs2_jax.results.progress import counted
    from slcs2_jax.results.run_config import read_config
    from slcs2_jax.results.run_folder import folders_with_config

    places = [place for place in folders_with_config(folder, passed) if read_config(place).evolves]
    found: dict[tuple[str, int, str], list[Findings]] = {}
    arms: set[str] = set()
    for place in counted(places, "runs read:"):
        one = read_run(place)
        name = arm_of(one.settings)
        arms.add(name)
        if one.summary is None:
            passed.append(f"{place}: has not ended")
        elif arm in (None, name):
            cell = cell_of(one.settings)
            world = ", ".join(one.settings.worlds) or cell.title
            key = arm_title(name), CELLS.index(cell), world
            found.setdefault(key, []).extend(
                findings(one.best(instance), one, instance) for instance in range(one.settings.instances)
            )
    if not found:
        of = f" of arm={arm}; there are {', '.join(sorted(arms))}" if arm and arms else ""
        raise InputError(f"folder={folder}: holds no finished run of evolution{of}; accepted is a folder with such")
    grouped: dict[str, dict[str, list[Findings]]] = {}
    for title, at, world in sorted(found):
        grouped.setdefault(title, {})[world] = found[title, at, world]
    return grouped
