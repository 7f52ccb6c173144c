"""The program that a GPU of the H100 class would run, compiled without one: kernels, copies, bytes, graphs."""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.options import CELLS, Parser, choice, listed, whole

DEVICE = Path(__file__).with_name("h100.txtpb")
PLUGINS = ("jax_cuda12_plugin", "jax_cuda13_plugin")
NOTES = """\
Nothing was run. Kernels are what the device is given to do in a chunk, copies among them; bytes are what they read and
write, each operand once, whatever a cache would spare; per time-step of the batch, and of one episode. Launches outside
of graphs are those that the host makes in a chunk when loops are captured in CUDA graphs; waits, how often it must look
at a result before it can go on.
"""


def main(arguments: list[str] | None = None) -> int:
    """Compile what the command line asks for, print, and save."""
    parser = Parser("gpu_program", __doc__)
    cells = choice(*CELLS)
    parser.add_argument("--cells", type=listed(cells), default=("open/short", "urban/short"), help="worlds")
    parser.add_argument("--batch", type=listed(whole(1, 65536)), default=(240, 4096), help="episodes at once")
    parser.add_argument("--agents", type=whole(2, 64), default=12, help="agents")
    parser.add_argument("--rules", type=whole(1, 1000), default=100, help="rules per agent")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="leave what the compiler writes there")
    return parser.run(partial(measure, parser), arguments)


def measure(command_line: Parser, options: argparse.Namespace) -> None:
    """Compile the advance of a rollout for every cell and batch."""
    command_line.check_folders(options.json)
    if options.keep is not None and not options.keep.is_dir():
        command_line.error(f"--keep: {options.keep} is no folder; accepted is one that exists")
    if not any(map(importlib.util.find_spec, PLUGINS)):
        command_line.error("needs JAX's plugin for CUDA; accepted is an environment with the extra gpu-tools installed")
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        # read when the compiler is first used: before that, no part of JAX may be
        given = os.environ.get("XLA_FLAGS", "")
        os.environ["XLA_FLAGS"] = f"{given} --xla_dump_to={folder} --xla_dump_hlo_as_text"
        os.environ["JAX_PLATFORMS"] = "cpu"
        _report(options, folder)


def _report(options: argparse.Namespace, folder: Path) -> None:
    from benchmarks.report import Report, figure, markdown
    from benchmarks.workload import settings_of
    from slcs2_jax.config import Compute

    compute = Compute(devices=1, cache=False)
    report = Report("gpu_program", options.command, compute, NOTES)
    print(report.heading())
    shown = []
    for cell in options.cells:
        settings = settings_of(cell, agents=options.agents, rules=options.rules, compute=compute)
        for batch in options.batch:
            row = {"batch": batch, **compiled(settings, batch, folder)}
            report.add(cell, [row])
            names = ("kernels_per_step", "copies_per_step", "kilobytes_per_env_step")
            counted = ("launches_outside_graphs", "graphs", "waits", "compile_seconds")
            shown.append([f"{cell}, {batch}", *(figure(row[name]) for name in (*names, *counted))])
    header = ["world, batch", "kernels/step", "copies/step", "kB/env-step", "outside graphs", "graphs", "waits", "s"]
    print(markdown(header, shown))
    print(report.notes())
    report.save(options.json)


def compiled(settings: Any, batch: int, folder: Path) -> dict[str, Any]:
    """Figures of the program for random rules; ``folder`` is where the compiler was told to write."""
    from benchmarks.gpu_counts import count, graphs

    start = time.perf_counter()
    before = set(folder.iterdir())
    text, steps = advance(settings, batch)
    written = [path for path in set(folder.iterdir()) - before if ".jit_advance." in path.name]
    after = [path for path in written if path.name.endswith("thunk_sequence_after_thunk_passes.txt")]
    [sequence] = after or [path for path in written if path.name.endswith("thunk_sequence.txt")]
    found = count(text)
    started, outside = graphs(sequence.read_text())
    return {
        "kernels_per_step": found.kernels / steps,
        "copies_per_step": found.copies / steps,
        "kilobytes_per_env_step": found.bytes / steps / batch / 1000,
        "graphs": started,
        "launches_outside_graphs": outside,
        "waits": found.waits,
        "compile_seconds": time.perf_counter() - start,
    }


def advance(settings: Any, batch: int) -> tuple[str, int]:
    """The optimised program of a chunk for random rules in the median scenario, as text, and its steps."""
    import jax
    import numpy as np
    from jax.experimental import topologies
    from jax.sharding import Mesh

    from benchmarks.workload import random_workload
    from slcs2_jax import programs, rollout
    from slcs2_jax.episode import Parameters
    from slcs2_jax.policy.rules import Rules
    from slcs2_jax.world.arena import wall_capacity

    workload = random_workload(settings, 1, median=True)
    agents, rules = settings.swarm.agents, settings.rules.rules
    shape = rollout.Shape(agents, 1 + max(workload.channels), wall_capacity(workload.scenarios))
    parameters = Parameters.of(settings, language=workload.language)
    vacant = rollout._vacant(shape, Rules.like(rules, agents, workload.language), batch)
    given = (*vacant, np.zeros((2, batch), np.uint32))
    leaves, structure = jax.tree.flatten((given, parameters))
    described = tuple(jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in leaves)
    periods = max(1, round(settings.compute.chunk / settings.swarm.sharing_period))
    device = topologies.get_topology_desc(platform="cuda", target_config=DEVICE.read_text(), topology="1x1x1").devices
    mesh = Mesh(np.array(device), (programs.AXIS,))
    _, program, _ = programs._programs(mesh, periods, structure, described)
    return program.as_text(), periods * settings.swarm.sharing_period


if __name__ == "__main__":
    sys.exit(main())
