"""Whole searches: evaluations per second, and where the time and the memory go."""

from __future__ import annotations

import argparse
import dataclasses
import resource
import sys
import tempfile
from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from benchmarks.options import CELLS, Parser, choice, listed, whole
from benchmarks.process import tables_of
from benchmarks.report import Report, figure, markdown
from slcs2_jax import runtime
from slcs2_jax.config import Compute, Search

NOTES = """\
Searches with everything that belongs to them: decoding, domination, exchange, re-evaluation and the winners' fresh
deployments; {folder}. Every row is one process, before which another one compiled its programs; compiling is getting
them, from the compiler or its cache, and not in the rates. Device: the host waits for the devices; host: the devices
wait for the host. Evaluations are episodes that counted; useful is their share of all slots' time-steps, the rest
were speculation, vacant slots, and what a chunk does after an episode's end. MB/run is what the greatest resident
memory grew by from the row above, for each run more.
"""


def parser() -> Parser:
    """The command line."""
    made = Parser("generation", __doc__)
    add = made.add_argument
    add("--cell", type=choice(*CELLS), default="open/short", help="world")
    add("--instances", type=listed(whole(1, 10**5)), default=(24, 240), metavar="N,...", help="runs together")
    add("--generations", type=whole(1, 10**7), default=5, help="of every run")
    add("--fresh", type=whole(1, 10**6), default=1, help="fresh deployments of every winner")
    add("--time-limit", type=whole(1, 10**7), help="steps of an episode; without it, the cell's own")
    add("--chunk", type=whole(1, 10**6), default=Compute.chunk, help="steps between refills")
    add("--slots", type=whole(1, 10**6), help="episodes advanced together; without it, as the search chooses")
    add("--folder", action="store_true", help="write run folders as well; saving the last solutions is then in host")
    add("--here", action="store_true", help="one number of instances, in this process and without rehearsal")
    add("--devices", type=whole(1, 1024), help="devices to use; without it all (CPU: one per core)")
    add("--native", type=choice("auto", "on", "off"), default="auto", help="who computes: the native chunk, or XLA")
    return made


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark; returns its exit code."""
    command_line = parser()
    return command_line.run(partial(measure, command_line), arguments)


def measure(command_line: Parser, options: argparse.Namespace) -> None:
    """Measure every number of instances, print and save."""
    command_line.check_folders(options.json)
    if options.here and len(options.instances) > 1:
        command_line.error("--here: accepted is one number of instances")
    rows = [] if options.here else [_elsewhere(options, instances) for instances in options.instances]
    compute = Compute(devices=options.devices, chunk=options.chunk, slots=options.slots, native=options.native)
    runtime.configure(compute)
    rows = rows or [measure_search(options, options.instances[0], compute)]
    for before, row in pairwise(rows):
        more = row["instances"] - before["instances"]
        row["bytes_per_run"] = (row["peak_bytes"] - before["peak_bytes"]) / more
    folder = "with run folders, the saving of all last solutions" if options.folder else "without run folders"
    report = Report("generation", options.command, compute, notes=NOTES.format(folder=folder))
    report.add(options.cell, rows)
    print(report.heading())
    print(f"### {options.cell}\n\n{_table(rows)}\n{report.notes()}")
    report.save(options.json)


def _elsewhere(options: argparse.Namespace, instances: int) -> dict[str, Any]:
    """In a process of its own, whose memory is nobody else's, after one that leaves the compiled programs behind."""

    def play(**others: int) -> dict[str, Any]:
        arguments: list[object] = []
        for name, value in (vars(options) | {"instances": instances} | others).items():
            if name not in ("command", "json", "here", "folder") and value is not None:
                arguments += [f"--{name.replace('_', '-')}", value]
        arguments += ["--folder"] * options.folder
        return tables_of("generation", [*arguments, "--here"])[options.cell][0]

    rehearsal = play(generations=1, time_limit=1, fresh=1)
    return play() | {"compile_seconds": rehearsal["compile_seconds"]}


def measure_search(options: argparse.Namespace, instances: int, compute: Compute) -> dict[str, Any]:
    """One evolution run of so many instances."""
    from benchmarks.workload import settings_of
    from slcs2_jax import evolve  # starts JAX

    settings = settings_of(options.cell, compute=compute)
    limit = options.time_limit or settings.world.time_limit
    with tempfile.TemporaryDirectory() as folder:
        settings = dataclasses.replace(
            settings,
            world=dataclasses.replace(settings.world, time_limit=limit),
            search=Search(generations=options.generations, fresh_deployments=options.fresh),
            instances=instances,
            run_dir=str(Path(folder) / "run") if options.folder else None,
        )
        (summary,) = evolve(settings)
    evaluations = sum(one.evaluations for one in summary.instances) + instances * options.fresh
    running = summary.wall_seconds - summary.compile_seconds
    host = summary.host_share * running
    return {
        "instances": instances,
        "generations": options.generations,
        "time_limit": limit,
        "evaluations": evaluations,
        "compile_seconds": summary.compile_seconds,
        "device_seconds": running - host,
        "host_seconds": host,
        "host_share": summary.host_share,
        "useful_share": summary.useful_share,
        "evaluations_per_second": evaluations / running,
        "env_steps_per_second": summary.env_steps_per_second * summary.wall_seconds / running,
        "peak_bytes": _peak_bytes(),
    }


def _peak_bytes() -> int:
    """The greatest resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def _table(rows: Sequence[dict[str, Any]]) -> str:
    header = ["runs", "generations", "T", "evaluations", "evaluations/s", "env-steps/s", "compile s", "device s",
              "host s", "host share", "useful", "peak MB", "MB/run"]  # fmt: skip
    lines = []
    for row in rows:
        lines.append([
            *(str(row[name]) for name in ("instances", "generations", "time_limit", "evaluations")),
            *(figure(row[f"{name}_per_second"]) for name in ("evaluations", "env_steps")),
            *(figure(row[f"{name}_seconds"]) for name in ("compile", "device", "host")),
            f"{row['host_share']:.2%}",
            f"{row['useful_share']:.1%}",
            figure(row["peak_bytes"] / 1e6),
            figure(row["bytes_per_run"] / 1e6 if "bytes_per_run" in row else None),
        ])  # fmt: skip
    return markdown(header, lines)


if __name__ == "__main__":
    raise SystemExit(main())
