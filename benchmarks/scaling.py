"""What a step costs against agents, rules, walls, batch size and devices: one factor at a time."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.options import CELLS, Parser, choice, listed, whole
from benchmarks.process import tables_of
from benchmarks.report import Report, figure, markdown
from benchmarks.rounds import Play, Spread, interleave
from slcs2_jax import runtime
from slcs2_jax.config import Compute

FACTORS = ("agents", "rules", "walls", "batch", "devices")
SPACING = 5.0  # m between buildings for the walls: twice as many as in the paper's worlds
NOTES = """\
Only steps of running episodes count; every slot is busy. Each figure is the median of the rounds, with the least and
the greatest; the points of all factors but devices are taken round by round. All play the first {steps} steps of their
episodes, with random rules. Where a factor does not say otherwise: {cell}, {agents} agents, {rules} rules, {batch}
episodes at once, {devices}. Walls stand in short urban worlds with a building every {spacing:g} m, the surplus taken
away. Every number of devices has a process of its own.
"""


@dataclass(frozen=True)
class Point:
    """One setting of one factor, and all that it leaves at its default."""

    factor: str
    value: int
    cell: str
    agents: int
    rules: int
    walls: int | None
    batch: int


def parser() -> Parser:
    """The command line."""
    made = Parser("scaling", __doc__)
    count = whole(1, 10**6)
    add = made.add_argument
    add("--factors", type=listed(choice(*FACTORS)), default=FACTORS, metavar="NAME,...", help="what to vary")
    add("--agents", type=listed(whole(2, 64)), default=(2, 4, 8, 12, 16, 32, 64), metavar="N,...", help="agents")
    add("--rules", type=listed(whole(1, 1000)), default=(25, 50, 100, 200, 400), metavar="N,...", help="per agent")
    add("--walls", type=listed(whole(0, 300)), default=(0, 16, 32, 64, 128, 256), metavar="N,...", help="walls")
    add("--batch", type=listed(count), metavar="N,...", help="episodes at once; without it, as the device likes")
    add("--devices", type=listed(whole(1, 1024)), metavar="N,...", help="devices; without it one, two, four, ..., all")
    add("--cell", type=choice(*CELLS), default="open/short", help="world of every factor but walls")
    add("--base-batch", type=count, help="episodes at once of the other factors; without it, as the device likes")
    add("--use", type=whole(1, 1024), metavar="N", help="devices of the other factors; without it all")
    add("--steps", type=whole(1, 10**7), default=2000, help="cut every episode there")
    add("--repeats", type=whole(1, 1000), default=5, help="rounds")
    add("--plot", type=Path, metavar="PATH", help="draw it (.png, .svg or .pdf); needs the extra `plot`")
    return made


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark; returns its exit code."""
    command_line = parser()
    return command_line.run(partial(measure, command_line), arguments)


def measure(command_line: Parser, options: argparse.Namespace) -> None:
    """Measure every factor, print, plot and save."""
    command_line.check_folders(options.json, options.plot)
    if options.plot is not None and options.plot.suffix not in (".png", ".svg", ".pdf"):
        command_line.error(f"--plot: {options.plot}: accepted are names that end in .png, .svg or .pdf")
    compute = Compute(devices=options.use, chunk=min(Compute.chunk, options.steps))
    runtime.configure(compute)
    on_cpu = runtime.devices(compute)[0].platform == "cpu"
    options.batch = options.batch or ((16, 32, 64, 128, 256) if on_cpu else (16, 64, 256, 1024, 4096, 16384))
    options.base_batch = options.base_batch or (64 if on_cpu else 4096)
    options.devices = options.devices or _doubling(len(runtime.devices(Compute())))
    notes = NOTES.format(
        steps=options.steps, cell=options.cell, agents=12, rules=100, batch=options.base_batch,
        devices=runtime.describe_devices(compute), spacing=SPACING,
    )  # fmt: skip
    report = Report("scaling", options.command, compute, notes=notes)
    print(report.heading())
    rows = measure_points(options, points(options), compute)
    if "devices" in options.factors:
        rows += [measure_devices(options, number) for number in options.devices]
    for factor in options.factors:
        found = [row for row in rows if row["factor"] == factor]
        report.add(factor, found)
        print(f"### {factor}\n\n{_table(factor, found)}", flush=True)
    print(report.notes())
    if options.plot is not None:
        from benchmarks.plot import draw

        draw(report.tables, options.plot, report.about["machine"]["devices"])
    report.save(options.json)


def points(options: argparse.Namespace) -> list[Point]:
    """Everything that is measured in this process."""
    base: dict[str, Any] = {
        "cell": options.cell, "agents": 12, "rules": 100, "walls": None, "batch": options.base_batch,
    }  # fmt: skip
    found = []
    for factor in options.factors:
        if factor == "devices":
            continue
        here = base | ({"cell": "urban/short"} if factor == "walls" else {})
        found += [Point(factor, value, **(here | {factor: value})) for value in getattr(options, factor)]
    return found


def measure_points(options: argparse.Namespace, found: Sequence[Point], compute: Compute) -> list[dict[str, Any]]:
    """Prepare all, play round by round; a row for each."""
    from benchmarks import batch  # starts JAX

    contestants: dict[str, Callable[[], Play]] = {}
    about: dict[str, dict[str, Any]] = {}
    for point in found:
        workload = _workload(point, compute).cut(options.steps)
        rollout = batch.make_rollout(workload, point.batch)
        name = f"{point.factor} {point.value}"
        about[name] = {
            "factor": point.factor,
            "value": point.value,
            "slots": rollout.slots,
            "compile_seconds": rollout.compile_seconds,
            "bytes_per_slot": rollout.held_bytes / rollout.slots,
        }
        batch.play(rollout, workload.cut(1).job, point.batch, rollout.steps_per_chunk)  # what happens once
        contestants[name] = partial(batch.play, rollout, workload.job, point.batch, options.steps)
    plays = interleave(contestants, options.repeats)
    return [about[name] | _figures(plays[name]) for name in contestants]


def measure_devices(options: argparse.Namespace, number: int) -> dict[str, Any]:
    """One number of devices: the number is fixed when JAX starts, so this takes another process."""
    arguments = [
        "--factors", "batch", "--batch", options.base_batch, "--cell", options.cell, "--use", number,
        "--steps", options.steps, "--repeats", options.repeats,
    ]  # fmt: skip
    row = tables_of("scaling", arguments)["batch"][0]
    return row | {"factor": "devices", "value": number}


def _workload(point: Point, compute: Compute) -> Any:
    from benchmarks.workload import random_workload, settings_of, with_walls

    settings = settings_of(point.cell, agents=point.agents, rules=point.rules, compute=compute)
    if point.walls is None:
        return random_workload(settings, 16, median=True)
    denser = dataclasses.replace(settings, world=dataclasses.replace(settings.world, building_spacing=SPACING))
    workload = random_workload(denser, 16, median=False)
    return dataclasses.replace(workload, scenarios=(with_walls(denser, point.walls),) * 16)


def _doubling(most: int) -> tuple[int, ...]:
    return tuple(sorted({most, *(2**k for k in range(most.bit_length()) if 2**k <= most)}))


def _figures(found: Sequence[Play]) -> dict[str, Any]:
    rates = [play.rate for play in found]
    return {
        "env_steps_per_second": Spread.of(rates).as_dict(),
        "microseconds_per_env_step": Spread.of([1e6 / rate for rate in rates]).as_dict(),
        "useful_share": sum(play.steps for play in found) / sum(play.slot_steps for play in found),
    }


def _table(factor: str, rows: Sequence[dict[str, Any]]) -> str:
    header = [factor, "slots", "env-steps/s", "least – greatest", "µs/env-step", "useful", "compile s", "kB/slot"]
    lines = []
    for row in rows:
        rate = row["env_steps_per_second"]
        lines.append([
            str(row["value"]),
            str(row["slots"]),
            figure(rate["median"]),
            f"{figure(rate['low'])} – {figure(rate['high'])}",
            figure(row["microseconds_per_env_step"]["median"]),
            f"{row['useful_share']:.1%}",
            figure(row["compile_seconds"]),
            figure(row["bytes_per_slot"] / 1e3),
        ])  # fmt: skip
    return markdown(header, lines)


if __name__ == "__main__":
    raise SystemExit(main())
