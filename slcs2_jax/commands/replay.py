"""slcs2 replay: an episode as an animation, a span of it as a picture, or all of it as a table."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.commands import suite_replay
from slcs2_jax.commands.looked_at import look_at, new_file, one_of, told_apart, with_swarm
from slcs2_jax.commands.policies import policy_named
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.escape import terminal

if TYPE_CHECKING:
    from slcs2_jax.config import Settings
    from slcs2_jax.looking.recording import Recording
    from slcs2_jax.results import SavedSolution

    Compute = Callable[..., Recording]  # takes after_chunk

TAKES_SETTINGS = True
HELP = """\
slcs2 replay RUN [option=value ...] [setting=value ...]: an episode of a solution; RUN is a run folder or a file (.npz)
slcs2 replay swarm=NAME [...]: of an evolved swarm that comes with slcs2, such as long_urban
slcs2 replay policy=NAME [...]: of another policy
slcs2 replay ENTRY suite=WORLD beside=ENTRY [...]: two entries of the benchmark (slcs2 suite list) in the same world

By default the best solution, in the world where it evolved, as an animation. Settings change the world: another
environment, range, seed, ...

  instance=0          of the run
  member=best         best, or the number of a member of the collection
  policy=NAME         what acts in the place of the solution: designed, the path of a text (docs/designed.md), a
                      policy's file .npz, or a name that plugins= brings
  beside=NAME         shown in the same world, below the first: likewise
  suite=WORLD         a world of the benchmark; policy= and beside= are entries then, and seed= one of its seeds
  training=0          with suite=: which training of an entry that is trained
  deployment=0        which of the fresh deployments in this world
  picture=animation   animation; layout: last places, links, and how many packets went from whom to whom;
                      paths: the way of every agent
  field=none          none, power or sinr: mean received power or SINR of the strongest sender, as a map under the rest
  start=0 end=auto    the span, time-steps; auto: the end of the episode. Later ones are not computed
  every=auto          time-steps from frame to frame; auto: so that there are about 300 frames
  fps=20              frames per second
  out=FILE            a new file: .gif or .mp4 of an animation; .png, .svg or .pdf of the others. Without it,
                      replay.gif, layout.png or paths.png. With .csv or .parquet, a table instead of a picture: who was
                      where at each time-step, sent a packet to whom, with what fate, by which rule
"""
_DEFAULTS: dict[str, Any] = {
    "instance": 0,
    "member": "best",
    "policy": None,
    "beside": None,
    "suite": None,
    "training": 0,
    "deployment": 0,
    "picture": "animation",
    "field": "none",
    "start": 0,
    "end": "auto",
    "every": "auto",
    "fps": 20,
    "out": None,
}
OPTIONS = tuple(_DEFAULTS)
_TABLES = (".csv", ".parquet")
_MOST_FPS = 100


def run(arguments: list[str]) -> int:
    """Show the episode that the arguments ask for."""
    subjects, options, assignments = told_apart(arguments, _DEFAULTS)
    in_suite = options["suite"] is not None
    if in_suite and len(subjects) < 2:
        suite_replay.check(options, subjects, assignments)
    subjects, assignments = with_swarm(subjects, assignments)
    if len(subjects) > 1 or not (subjects or options["policy"]):
        raise InputError("replay: accepted is slcs2 replay RUN, or policy=NAME (slcs2 replay --help)")
    one_of("picture", options["picture"], ("animation", "layout", "paths"))
    one_of("field", options["field"], ("none", "power", "sinr"))
    out = _output(options["out"], options["picture"])
    for name, most in (("end", None), ("every", None), ("fps", _MOST_FPS)):
        _whole(name, options[name], most)
    from slcs2_jax.config.compose import Job, run_hydra
    from slcs2_jax.config.overlay import deployment_primary

    solution = None
    if subjects and not in_suite:
        solution = look_at(subjects[0], options["instance"], options["member"])

    def together(jobs: list[Job]) -> list[float]:
        for job in jobs:
            if in_suite:
                _shown(suite_replay.episodes(options, subjects, job.config), "", options, out)
            else:
                _show(solution, job, options, out)
        return [0.0] * len(jobs)

    evolved = None if solution is None else solution.settings
    seed = 0 if solution is None else solution.instance_seed
    seed = suite_replay.first_seed(options["suite"]) if in_suite else seed
    run_hydra(deployment_primary("replay", evolved, own={}, seed=seed), CommandLine.parse(assignments), together)
    return 0


def _output(said: str | None, picture: str) -> Path:
    """Where the picture or table goes; refuses a format that cannot be written before anything is computed."""
    if said is not None and Path(said).suffix in _TABLES:
        table = new_file(said)
        assert table is not None
        if table.suffix == ".parquet":
            from slcs2_jax.looking.trace import parquet_writer

            parquet_writer()
        return table
    try:
        from slcs2_jax.looking import animation, drawing
    except ImportError as error:
        raise InputError(
            f"replay: {error.name} is not installed; accepted is an installation with slcs2_jax[plot]"
        ) from None
    path = new_file(said or ("replay.gif" if picture == "animation" else f"{picture}.png"))
    assert path is not None
    suffixes = animation.SUFFIXES if picture == "animation" else drawing.SUFFIXES
    if path.suffix not in suffixes:
        ends = " or ".join((*suffixes, *_TABLES))
        raise refuse("out", str(path), f"a file whose name ends in {ends} for picture={picture}")
    if path.suffix == ".mp4":
        animation.find_encoder()
    return path


def _whole(name: str, said: Any, most: int | None = None) -> None:
    """Refuse what is neither auto nor a whole number from 1 on."""
    if said == "auto":
        return
    text = str(said)
    if not (text.isascii() and text.isdecimal() and 0 < int(text) <= (most or 10**9)):
        above = f" to {most}" if most else " on, or auto"
        raise refuse(name, said, f"a whole number from 1{above}")


def _show(solution: SavedSolution | None, job: Any, options: dict[str, Any], out: Path) -> None:
    from slcs2_jax.config.overlay import deployment_settings

    settings = deployment_settings(job.config, None if solution is None else solution.settings)
    world = f", {settings.world.environment.replace('_', ' ')} {settings.world.range}"
    _shown(_episodes(solution, settings, settings.seed, options), world, options, out)


def _shown(episodes: list[tuple[str, Compute]], world: str, options: dict[str, Any], out: Path) -> None:
    """Compute the episodes and write what they look like; `world` follows their titles."""
    titles, recordings = [], []
    for title, compute in episodes:
        recordings.append(_computed(compute, title))
        one = recordings[-1]
        figure = f"fitness {one.fitness:.3f}" if one.ended else f"the first {one.steps} steps"
        titles.append(f"{title}{world}, seed {one.scenario.seed}, {figure}")
        print(terminal(titles[-1]), flush=True)
    _write(recordings, titles, options, out)


def _episodes(
    solution: SavedSolution | None, settings: Settings, seed: int, options: dict[str, Any]
) -> list[tuple[str, Compute]]:
    """What is to be shown: titles, and how each is computed."""
    from slcs2_jax.looking.solutions import replay

    steps = None if options["end"] == "auto" else int(options["end"])
    place = {"seed": seed, "deployment": options["deployment"], "steps": steps}
    found: list[tuple[str, Compute]] = []
    if options["policy"] is None and solution is not None:
        found.append(("evolved", partial(replay, solution, settings, **place)))
    for name in (options["policy"], options["beside"]):
        if name is not None:
            named = policy_named(name)
            found.append((terminal(named.title), partial(replay, named.policy, settings, **place)))
    return found


def _computed(compute: Compute, title: str) -> Recording:
    from slcs2_jax.results.progress import counting

    with counting(f"{title}: time-step") as count:
        return compute(after_chunk=count)


def _write(recordings: list[Recording], titles: list[str], options: dict[str, Any], out: Path) -> None:
    steps = max(one.steps for one in recordings)
    end = steps if options["end"] == "auto" else int(options["end"])
    start = options["start"]
    if not start < end <= steps:
        raise InputError(f"start={start} end={end}: accepted are 0 <= start < end <= {steps}, the steps of the episode")
    if out.suffix in _TABLES:
        from slcs2_jax.looking.trace import write_trace

        rows = write_trace(out, recordings, titles, start=start, end=end)
        print(f"table {terminal(str(out))}: {rows} rows", flush=True)
        return
    field = None if options["field"] == "none" else options["field"]
    if options["picture"] != "animation":
        from slcs2_jax.looking.drawing import own_style, write_figure
        from slcs2_jax.looking.still import still

        with own_style():
            write_figure(still(recordings, titles, options["picture"], start=start, end=end, field=field), out)
        print(f"{options['picture']} {terminal(str(out))}", flush=True)
        return
    from slcs2_jax.looking.animation import animate, check_frames, usual_stride
    from slcs2_jax.results.progress import counting

    every = usual_stride(end - start) if options["every"] == "auto" else int(options["every"])
    check_frames(end - start, every)
    with counting("frame") as count:
        frames = animate(
            recordings,
            titles,
            out,
            start=start,
            end=end,
            every=every,
            fps=options["fps"],
            field=field,
            after_frame=count,
        )
    print(f"replay {terminal(str(out))}: {frames} frames, {every} time-steps from one to the next", flush=True)
