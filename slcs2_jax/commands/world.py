"""slcs2 world: the world of a seed, or of a file, in words; and as a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config.compose import Job
    from slcs2_jax.world.layout import Floats, Scenario

TAKES_SETTINGS = True
OPTIONS = ("save",)
HELP = """\
slcs2 world [setting=value ...] [save=FILE]: say what is in the world of a seed, and write it to a file

  seed=0           of the world
  save=FILE.yaml   a new file with source, sink, walls, jammers, starts and time limit, lengths in m; change it, and
                   give it as world=FILE.yaml to evolve, evaluate or replay
"""
SAVE = "save="


def run(arguments: list[str]) -> int:
    """Describe the world that the arguments ask for, and save it."""
    line = CommandLine.parse(arguments)
    from slcs2_jax.config.compose import run_hydra
    from slcs2_jax.config.store import Primary

    if line.sweep:
        raise InputError("option -m: not for world; accepted is one value for each setting")
    files = [argument.removeprefix(SAVE) for argument in line.overrides if argument.startswith(SAVE)]
    out = _new_file(files[-1]) if files else None

    def together(jobs: list[Job]) -> list[float]:
        _show(jobs[0], out)
        return [0.0]

    run_hydra(Primary(name="world"), line.without(SAVE), together)
    return 0


def _new_file(text: str) -> Path:
    from slcs2_jax.config.door import present
    from slcs2_jax.config.world_text import SUFFIXES

    path = Path(text)
    if path.suffix not in SUFFIXES or present(path) or not path.parent.is_dir():
        raise InputError(f"save={text}: accepted is a new file .yaml in a folder that exists")
    return path


def _show(job: Job, out: Path | None) -> None:
    from slcs2_jax.config import settings_from
    from slcs2_jax.results.files import write_text
    from slcs2_jax.world.scenario import make_scenario
    from slcs2_jax.world.world_file import scenario_text

    settings = settings_from(job.config)
    scenario = make_scenario(settings, settings.seed)
    print("\n".join(_lines(scenario)))
    if out is not None:
        write_text(out, scenario_text(scenario))
        print(f"world {terminal(str(out))}", flush=True)


def _lines(scenario: Scenario) -> list[str]:
    """What is in the world, a line for each thing."""
    lines = [
        f"{scenario.environment}, seed {scenario.seed}: {scenario.time_limit:,d} steps at most",
        f"sink       {_place(scenario.sink)}, believed to be at {_place(scenario.sink_estimate)}",
        f"walls      {len(scenario.vertical)} across and {len(scenario.horizontal)} along, "
        f"{scenario.wall_thickness:g} m thick",
        f"agents     {len(scenario.start)}, first at {_place(scenario.start[0])}",
    ]
    for number, one in enumerate(scenario.jammers):
        route = "".join(f", {_place(point)}" for point in one.route)
        lines.append(
            f"jammer {number}   {_place(one.place)}{route}; {one.emission}, {one.motion}, {one.power_db:+g} dB"
        )
    return lines if scenario.jammers else [*lines, "jammers    none"]


def _place(place: Floats) -> str:
    return f"({place[0]:.1f}, {place[1]:.1f})"
