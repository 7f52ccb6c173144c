"""Environment steps, agent steps and evaluations per second against batch size, beside the serial peers."""

from __future__ import annotations

import argparse
import dataclasses
import importlib.util
from argparse import BooleanOptionalAction
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks import peak
from benchmarks.options import CELLS, Parser, choice, listed, whole
from benchmarks.report import Report, figure, markdown
from benchmarks.rounds import CLOCKS, Play, Spread, clock, interleave, ratios
from slcs2_jax import runtime
from slcs2_jax.config import Compute
from slcs2_jax.native.build import BuildError
from slcs2_jax.results import load_solution

if TYPE_CHECKING:
    from benchmarks.workload import Workload

ON_CPU, ON_GPU = (1, 16, 32, 64, 240), (1, 16, 64, 240, 1024, 4096)
PEERS = ("numba-all", "numba-one", "python")
TITLES = {"numba-all": "Numba, all cores", "numba-one": "Numba, one core", "python": "plain Python"}
NOTES = """\
Only steps of running episodes count; slots whose episode ends get the next one. Compiling is not in the rates. Each
figure is the median of the rounds, with the least and the greatest; ratios are taken round by round. Everybody plays
the same episodes (scenarios, rules, keys) from their first step; {span}; but plain Python does {python} steps at each
of ten times, evenly spread over the first of them. Rules: {rules}. Urban: {urban}. Compiling is getting the programs,
from the compiler or its cache. {clock} {numba}
The limit is that of the arithmetic in the open: the operations that a step takes, as `benchmarks/peak.py` counts them,
at the rate at which {cores} makes independent multiplications and additions of vectors of its best width.
"""


def parser() -> Parser:
    """The command line."""
    made = Parser("throughput", __doc__)
    count = whole(1, 10**6)
    add = made.add_argument
    add("--cells", type=listed(choice(*CELLS)), default=("open/short", "urban/short", "open/long", "urban/long"),
        metavar="KIND/RANGE,...", help=f"worlds; of {', '.join(CELLS)}")  # fmt: skip
    add("--batch", type=listed(count), metavar="N,...", help="episodes at once; without it, as the device likes")
    add("--steps", type=whole(1, 10**7), help="cut every episode there; without it they are played to their end")
    add("--repeats", type=whole(1, 1000), default=5, help="rounds")
    add("--peers", type=listed(choice(*PEERS, "none")), default=PEERS, help="whom to compare with, or none")
    add("--episodes", type=count, default=16, help="different scenarios and solutions; the Numba peers play each once")
    add("--python-steps", type=count, default=10, help="steps of plain Python at each of ten times in an episode")
    add("--fastmath", action=BooleanOptionalAction, default=True, help="let Numba relax floating point: a bit faster")
    add("--cache", action=BooleanOptionalAction, default=True, help="keep programs that JAX compiled on disk")
    add("--spread", action="store_true", help="urban: scenarios of seeds 0, 1, ... in place of the median one")
    add("--solution", type=Path, metavar="PATH", help="a saved solution's rules in place of random ones")
    add("--agents", type=whole(2, 64), default=12, help="agents")
    add("--rules", type=whole(1, 1000), default=100, help="rules per agent")
    add("--devices", type=whole(1, 1024), help="devices to use; without it all (CPU: one per core)")
    add("--native", type=listed(choice("auto", "on", "off")), default=("auto", "off"), metavar="WHO,...",
        help="who computes: the native chunk (auto, on), and XLA (off)")  # fmt: skip
    add("--clock", choices=tuple(CLOCKS), default="wall",
        help="the wall's, or the processor's: rates of a core, for a machine that is busy otherwise")  # fmt: skip
    return made


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark; returns its exit code."""
    command_line = parser()
    return command_line.run(partial(measure, command_line), arguments)


def measure(command_line: Parser, options: argparse.Namespace) -> None:
    """Measure every cell, print as it goes, save at the end."""
    command_line.check_folders(options.json)
    if options.peers == ("none",):
        options.peers = ()
    elif "none" in options.peers:
        command_line.error("--peers: none stands alone")
    elif importlib.util.find_spec("numba") is None:
        command_line.error("--peers: they need Numba, which is not installed; accepted is none")
    if options.solution is not None:
        load_solution(options.solution)  # complains before anything is printed
    chunk = min(Compute.chunk, options.steps or Compute.chunk)
    compute = Compute(devices=options.devices, chunk=chunk, cache=options.cache, native=options.native[0])
    clock.name = options.clock
    runtime.configure(compute)
    report = Report("throughput", options.command, compute, notes=_notes(options))
    print(report.heading())
    for cell in options.cells:
        rows = measure_cell(options, cell, compute)
        report.add(cell, rows)
        walls = sorted({count for row in rows for count in row["walls"]})
        print(f"### {cell}, {walls[0]}{f' to {walls[-1]}' if walls[1:] else ''} walls\n\n{_table(rows)}", flush=True)
    print(report.notes())
    report.save(options.json)


@dataclass(frozen=True)
class Contestant:
    """Who plays: a batch, or a peer, which has no slots."""

    play: Callable[[], Play]
    compile_seconds: float | None
    slots: int | None = None


def measure_cell(options: argparse.Namespace, cell: str, compute: Compute) -> list[dict[str, Any]]:
    """Rows of one cell: a row for every batch size and every peer."""
    from benchmarks.workload import random_workload, saved_workload, settings_of  # starts JAX

    settings = settings_of(cell, agents=options.agents, rules=options.rules, compute=compute)
    median = not options.spread
    if options.solution is None:
        workload = random_workload(settings, options.episodes, median=median)
    else:
        workload = saved_workload(settings, options.solution, options.episodes, median=median)
    limit = settings.world.time_limit
    steps = min(options.steps or limit, limit)
    workload = workload.cut(steps)
    contestants = _batches(options, workload, steps) | _peers(options, workload)
    limit_rate = _limit(options, workload)
    plays = interleave({name: one.play for name, one in contestants.items()}, options.repeats)
    return [
        {"name": name, "slots": one.slots, "compile_seconds": one.compile_seconds}
        | figures(name, plays, workload.settings.swarm.agents, to_their_end=steps == limit)
        | {"walls": [scenario.walls for scenario in workload.scenarios], "limit": limit_rate}
        for name, one in contestants.items()
    ]


def _limit(options: argparse.Namespace, workload: Workload) -> float | None:
    """Env-steps per second by the machine's arithmetic alone, in the open; None without a compiler."""
    if workload.settings.world.buildings:
        return None
    try:
        found = peak.peak() / peak.operations(workload.settings, workload.language.words)
    except BuildError:
        return None
    return found if options.clock == "cpu" else found * runtime.available_cores()


def _batches(options: argparse.Namespace, workload: Workload, steps: int) -> dict[str, Contestant]:
    """Every batch size, warm; sizes that come to the same number of slots share theirs."""
    from benchmarks import batch

    on_cpu = runtime.devices(workload.settings.compute)[0].platform == "cpu"
    made: dict[tuple[bool, int], Any] = {}
    found = {}
    for engine in options.native:
        for size in options.batch or (ON_CPU if on_cpu else ON_GPU):
            rollout = batch.make_rollout(workload, size, engine)
            rollout = made.setdefault((rollout.native, rollout.slots), rollout)
            play = partial(batch.play, rollout, workload.job, size, steps)
            name = f"{'native' if rollout.native else 'XLA'}, batch {size}"
            found[name] = Contestant(play, rollout.compile_seconds, rollout.slots)
    for rollout in made.values():  # what happens once, happens here
        batch.play(rollout, workload.cut(1).job, rollout.slots, rollout.steps_per_chunk)
    return found


def _peers(options: argparse.Namespace, workload: Workload) -> dict[str, Contestant]:
    """Whom to compare with, compiled."""
    if not options.peers:
        return {}
    from benchmarks.peers import Peers

    peers = Peers.of(workload, options.episodes, fastmath=options.fastmath)
    one, more = peers.compile()
    found = {}
    for name in options.peers:
        if name == "numba-all":
            found[name] = Contestant(peers.all_cores, one + more)
        elif name == "numba-one":
            found[name] = Contestant(peers.one_core, one)
        else:
            steps = min(options.python_steps, peers.worlds[0].time_limit)
            found[name] = Contestant(partial(peers.plain_python, peers.stretches(steps), steps), None)
    return found


def figures(name: str, plays: Mapping[str, Sequence[Play]], agents: int, *, to_their_end: bool) -> dict[str, Any]:
    """What the rounds come to for one of those who played."""
    found = plays[name]
    rates = [play.rate for play in found]
    lengths = [length for play in found for length in play.lengths] if to_their_end else []
    evaluations = Spread.of([rate * len(lengths) / sum(lengths) for rate in rates]).as_dict() if lengths else None
    return {
        "rounds": [dataclasses.asdict(play) for play in found],
        "env_steps_per_second": Spread.of(rates).as_dict(),
        "agent_steps_per_second": Spread.of([agents * rate for rate in rates]).as_dict(),
        "evaluations_per_second": evaluations,
        "seconds_per_slot_step": Spread.of([play.seconds / play.slot_steps for play in found]).as_dict(),
        "useful_share": sum(play.steps for play in found) / sum(play.slot_steps for play in found),
        "ratios": {peer: ratios(found, plays[peer]).as_dict() for peer in PEERS if peer in plays and peer != name},
    }


def _table(rows: Sequence[dict[str, Any]]) -> str:
    compared = [peer for peer in PEERS if any(peer in row["ratios"] for row in rows)]
    header = ["", "slots", "env-steps/s", "least – greatest", "agent-steps/s", "evaluations/s", "µs/batch step",
              "useful", "of the limit", "compile s", *(f"× {TITLES[peer]}" for peer in compared)]  # fmt: skip
    lines = []
    for row in rows:
        rate, evaluations = row["env_steps_per_second"], row["evaluations_per_second"]
        lines.append([
            TITLES.get(row["name"], row["name"]),
            "–" if row["slots"] is None else str(row["slots"]),
            figure(rate["median"]),
            f"{figure(rate['low'])} – {figure(rate['high'])}",
            figure(row["agent_steps_per_second"]["median"]),
            figure(evaluations and evaluations["median"]),
            figure(1e6 * row["seconds_per_slot_step"]["median"] * row["slots"] if row["slots"] else None),
            f"{row['useful_share']:.1%}",
            f"{rate['median'] / row['limit']:.0%}" if row["limit"] else "–",
            figure(row["compile_seconds"]),
            *(figure(row["ratios"][peer]["median"] if peer in row["ratios"] else None) for peer in compared),
        ])  # fmt: skip
    return markdown(header, lines)


def _notes(options: argparse.Namespace) -> str:
    return NOTES.format(
        python=options.python_steps,
        clock=f"Seconds are those of {'the wall' if options.clock == 'wall' else 'all cores that compute together'}.",
        cores="a core" if options.clock == "cpu" else "every core",
        numba=f"Numba: {'relaxed' if options.fastmath else 'strict'} floating point." if options.peers else "",
        span=f"each is cut after {options.steps} steps" if options.steps else "each is played to its end",
        rules=f"random, {options.episodes} solutions" if options.solution is None else f"of {options.solution.name}",
        urban=f"scenarios of seeds 0..{options.episodes - 1}"
        if options.spread
        else "the scenario with the median number of walls among those of seeds 0..100",
    )


if __name__ == "__main__":
    raise SystemExit(main())
