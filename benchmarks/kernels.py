"""Where the time of a step goes: its compiled kernels, by the function of the simulator that they come from."""

from __future__ import annotations

import argparse
import gzip
import json
import re
import statistics
import sys
import tempfile
from collections import defaultdict
from functools import partial
from pathlib import Path

import jax

from benchmarks import batch
from benchmarks.options import CELLS, Parser, choice, whole
from benchmarks.report import Report, figure, markdown
from benchmarks.workload import Workload, random_workload, settings_of
from slcs2_jax import runtime
from slcs2_jax.config import Compute
from slcs2_jax.rollout import LANES, Rollout

_FRAME = re.compile(r"^(\d+) \{file_location_id=(\d+)(?: parent_frame_id=(\d+))?\}", re.MULTILINE)
_LOCATION = re.compile(r"^(\d+) \{file_name_id=(\d+) function_name_id=(\d+) ", re.MULTILINE)
_NAME = re.compile(r'^(\d+) "(.*)"$', re.MULTILINE)
_KERNEL = re.compile(r"^ *(?:ROOT )?%([\w.-]+) = .*stack_frame_id=(\d+)", re.MULTILINE)
_NESTED = ("while", "conditional", "call", "Thunk")  # their time is that of the kernels in them


def main(arguments: list[str] | None = None) -> int:
    """Measure what the command line asks for, print, and save."""
    parser = Parser("kernels", __doc__)
    parser.add_argument("--cell", type=choice(*CELLS), default="open/short", help="the world")
    parser.add_argument("--slots", type=whole(1, 65536), default=LANES, help="episodes at once, on one device")
    parser.add_argument("--rows", type=whole(1, 1000), default=15, help="lines of the table")
    return parser.run(partial(measure, parser), arguments)


def measure(command_line: Parser, options: argparse.Namespace) -> None:
    """Profile some chunks of random rules at work on one device."""
    command_line.check_folders(options.json)
    compute = Compute(devices=1)
    runtime.configure(compute)
    workload = random_workload(settings_of(options.cell, compute=compute), LANES, median=True)
    rollout = batch.make_rollout(workload, options.slots, "off")
    batch.play(rollout, workload.job, rollout.slots, 4 * rollout.steps_per_chunk)
    notes = "Medians of each kernel's times under the profiler, which adds to the short ones. Kernels are put down to "
    notes += "the function that their last operation stands in; the compiler may have put others' work into them."
    report = Report("kernels", options.command, compute, notes)
    print(report.heading())
    found = by_function(profile(rollout, workload), rollout)
    total = sum(found.values())
    rows = [{"function": name, "us_per_step": us, "share": us / total} for name, us in found.items()]
    report.add(options.cell, rows)
    shown = [[row["function"], figure(row["us_per_step"]), f"{row['share']:.1%}"] for row in rows[: options.rows]]
    shown.append(["all", figure(total), "100.0%"])
    print(f"### {options.cell}, {rollout.slots} slots, one device\n")
    print(markdown(["function", "µs/batch step", "share"], shown))
    print(report.notes())
    report.save(options.json)


def profile(rollout: Rollout, workload: Workload) -> dict[str, float]:
    """µs per time-step of each kernel by name, of those that run in every chunk."""
    with tempfile.TemporaryDirectory() as folder:
        with jax.profiler.trace(folder, create_perfetto_trace=True):
            batch.play(rollout, workload.job, rollout.slots, 2 * rollout.steps_per_chunk)
        [trace] = Path(folder).rglob("perfetto_trace.json.gz")
        events = json.loads(gzip.decompress(trace.read_bytes()))["traceEvents"]
    times: dict[str, list[float]] = defaultdict(list)
    for event in events:
        if event.get("ph") == "X":
            times[event["name"]].append(event["dur"])
    steps = 2 * rollout.steps_per_chunk
    return {name: statistics.median(durations) * len(durations) / steps for name, durations in times.items()}


def by_function(kernels: dict[str, float], rollout: Rollout) -> dict[str, float]:
    """The same by file and function of the simulator, the greatest first."""
    origin = origins(rollout.compiled)
    found: dict[str, float] = defaultdict(float)
    for name, us in kernels.items():
        if name in origin and not name.startswith(_NESTED):
            found[origin[name]] += us
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def origins(text: str) -> dict[str, str]:
    """For each operation of a compiled program's text, the innermost function of the package that it comes from."""
    head = {part: text.partition(f"\n{part}\n")[2].partition("\n\n")[0] for part in ("FileNames", "FunctionNames")}
    files, functions = (dict(_NAME.findall(lines)) for lines in head.values())
    places = {number: (files[f], functions[g]) for number, f, g in _LOCATION.findall(text)}
    frames = {number: (place, parent) for number, place, parent in _FRAME.findall(text)}

    def name(frame: str) -> str:
        while frame in frames:
            (file, function), parent = places[frames[frame][0]], frames[frame][1]
            _, package, path = file.rpartition("/slcs2_jax/")
            if package:
                return f"{path} {function.rpartition('.')[2]}"
            if parent == frame:
                break
            frame = parent
        return "the compiler"

    return {kernel: name(frame) for kernel, frame in _KERNEL.findall(text)}


if __name__ == "__main__":
    sys.exit(main())
