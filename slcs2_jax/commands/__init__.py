"""The commands of slcs2: one module each, imported only when it is called."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import NamedTuple, Protocol, cast

from slcs2_jax.config.field import refuse


class Command(Protocol):
    """What a module of this package offers."""

    HELP: str  # what `slcs2 NAME --help` prints
    TAKES_SETTINGS: bool  # is the table of settings printed below that?
    OPTIONS: Sequence[str]  # what it takes as name=value beside settings and plugins=

    @staticmethod
    def run(arguments: list[str]) -> int:
        """Do what the arguments (those after the command's name) say; the exit code. Raises InputError."""
        ...


class Line(NamedTuple):
    """A command in the list of all of them."""

    arguments: str
    summary: str


# In the order of the list; command NAME is the module slcs2_jax.commands.NAME.
COMMANDS: dict[str, Line] = {
    "evolve": Line("[setting=value ...]", "one run of several instances; -m: one for every combination of values"),
    "resume": Line("FOLDER [generations=N]", "interrupted runs go on where they were saved, finished ones further"),
    "repeat": Line("FOLDER", "a finished run again from what its folder records: does it come to the same?"),
    "evaluate": Line("solution=PATH [setting=value ...]", "a saved solution on any scenarios"),
    "transfer": Line("FOLDER ... [setting=value ...]", "winners in worlds that they have not seen: a matrix, heat map"),
    "experiment": Line(
        "NAME [setting=value ...]", "an experiment of the paper or on searches, or the calibration study"
    ),
    "suite": Line("ACTION [ENTRY]", "the benchmark: its worlds and entries, trainings, evaluations, the table"),
    "world": Line("[setting=value ...] [save=FILE]", "the world of a seed in words, and as a file to change and use"),
    "watch": Line("FOLDER", "progress of runs that another process computes"),
    "replay": Line(
        "RUN [setting=value ...]", "an episode as an animation or a picture: who sent to whom, and what was lost"
    ),
    "rules": Line("RUN", "a solution's rules in words: what they learnt, how they acted, where they came from"),
    "found": Line("FOLDER", "what evolution found: reflexes switched off, rules that act most, how packets travel"),
    "parts": Line("[KIND]", "what a swarm, its world and its search are made of, and which setting chooses it"),
    "report": Line("FOLDER", "a page to look at; of many runs also tables, figures, verdicts on the paper's claims"),
}


def find(name: str) -> Command:
    """The command of this name; raises InputError if there is none."""
    if name not in COMMANDS:
        raise refuse("command", name, "one of " + ", ".join(COMMANDS) + " (slcs2 --help)")
    return cast(Command, importlib.import_module(f"{__name__}.{name}"))


def listing() -> str:
    """A line for each command."""
    calls = {f"slcs2 {name} {line.arguments}": line.summary for name, line in COMMANDS.items()}
    width = max(map(len, calls))
    return "".join(f"  {call:{width}}  {summary}\n" for call, summary in calls.items())
