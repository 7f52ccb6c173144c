"""What the commands that look at a run read from their arguments: a run folder or a saved solution, and options."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.field import refuse, show

if TYPE_CHECKING:
    from slcs2_jax.results import FinishedRun, SavedSolution


def subject_and_options(
    command: str, arguments: Sequence[str], defaults: Mapping[str, Any]
) -> tuple[str, dict[str, Any]]:
    """The one argument that is no option, and the options, each in the type of its default (None: a text).

    Raises InputError naming what is not accepted.
    """
    subjects, options, others = told_apart(arguments, defaults)
    subjects, others = with_swarm(subjects, others)
    if len(subjects) != 1:
        raise InputError(f"{command}: accepted is slcs2 {command} RUN [option=value ...] (slcs2 {command} --help)")
    if others:
        raise refuse("option", others[0].partition("=")[0], "one of " + ", ".join(defaults))
    return subjects[0], options


def told_apart(arguments: Sequence[str], defaults: Mapping[str, Any]) -> tuple[list[str], dict[str, Any], list[str]]:
    """What is no assignment; the options, each in the type of its default (None: a text); and other assignments.

    Raises InputError for a value that its option cannot have, and for an argument with a dash.
    """
    subjects: list[str] = []
    options, others = dict(defaults), []
    for argument in arguments:
        name, equals, text = argument.partition("=")
        if argument.startswith("-"):
            raise refuse("option", argument, "--help, or option=value")
        if not equals or Path(argument).exists():
            subjects.append(argument)
        elif name in defaults:
            options[name] = _value(name, text, defaults[name])
        else:
            others.append(argument)
    return subjects, options, others


def with_swarm(subjects: Sequence[str], others: Sequence[str]) -> tuple[list[str], list[str]]:
    """Subjects and assignments once more, swarm=NAME as the path of the swarm. Raises InputError if there is none."""
    from slcs2_jax.results.swarms import swarm_file

    swarms = [text for name, _, text in (other.partition("=") for other in others) if name == "swarm"]
    rest = [other for other in others if other.partition("=")[0] != "swarm"]
    return [*subjects, *(str(swarm_file(name)) for name in swarms)], rest


def _value(name: str, text: str, default: Any) -> Any:
    if isinstance(default, bool):
        if text not in ("on", "off", "true", "false"):
            raise refuse(name, text, "on or off")
        return text in ("on", "true")
    if isinstance(default, int):
        if not (text.isascii() and text.isdecimal() and len(text) < 10):
            raise refuse(name, text, "a whole number >= 0")
        return int(text)
    return text


def one_of(name: str, value: str, accepted: Sequence[str]) -> str:
    """The value if it is one of those accepted; raises InputError."""
    if value not in accepted:
        raise refuse(name, value, "one of " + ", ".join(accepted))
    return value


def new_file(path: str | None) -> Path | None:
    """Where output goes, None for the terminal. Raises InputError if the file exists or its folder does not."""
    if path is None:
        return None
    from slcs2_jax.config.door import present

    file = Path(path)
    if present(file):
        raise InputError(f"out={show(path)}: exists; accepted is a new file")
    if not file.parent.is_dir():
        raise InputError(f"out={show(path)}: there is no folder {show(str(file.parent))}; accepted is a file in one")
    return file


def look_into(path: str) -> FinishedRun:
    """The run of evolution in a folder; says so if it has not ended. Raises InputError if the folder holds none."""
    from slcs2_jax.config.door import present
    from slcs2_jax.results import read_run
    from slcs2_jax.results.run_config import CONFIG, read_config

    if not present(Path(path) / CONFIG):
        raise InputError(f"run={show(path)}: holds no run; accepted is the folder of a run")
    if not read_config(Path(path)).evolves:
        raise InputError(f"run={show(path)}: holds an evaluation; accepted is the folder of a run of evolution")
    run = read_run(path)
    if run.summary is None:
        done = len(run.rows) / run.settings.instances
        print(
            f"{terminal(path)} has not ended: {done:.0f} of {run.settings.search.generations} generations; shown is "
            "what was saved last",
            file=sys.stderr,
        )
    return run


def look_at(path: str, instance: int, member: str) -> SavedSolution:
    """The solution that is asked for: in a run folder, or a saved one itself. Raises InputError if there is none."""
    from slcs2_jax.results import load_solution

    if Path(path).suffix == ".npz" or os.path.isfile(path):
        return load_solution(path)
    run = look_into(path)
    from slcs2_jax.looking.solutions import member_of

    return member_of(run, instance, member)
