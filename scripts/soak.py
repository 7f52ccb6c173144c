"""Continuous evolution at full size: python scripts/soak.py --minutes 60 --out FILE [setting=value ...].

Runs of a few generations each follow one another in one process, each with new seeds and a folder that is looked at and
thrown away. Resident memory and throughput are sampled all the while; after a warm-up both must stay where they are.
Throughput is judged per second of processor time, which other work on the machine disturbs less. Printed and written as
JSON: the drift of all, and what of the invariants did not hold. Exit code 0 if memory stays within 2 % and throughput
within 5 %, and everything holds.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.commands.changes import changed
from slcs2_jax.config import InputError, Search, Settings, World
from slcs2_jax.results import Quiet, read_run

# from the end of the warm-up to the end
MOST_DRIFT = {"resident_mb": 0.02, "env_steps_per_cpu_s": 0.05}
SAMPLED = ("resident_mb", "env_steps_per_cpu_s", "env_steps_per_s")
PAGE = 4096


class Sampler(Quiet):
    """Samples resident memory and throughput every few seconds."""

    def __init__(self, every: float) -> None:
        self.every, self.start = every, time.monotonic()
        self.samples: list[dict[str, float]] = []
        self._last = (self.start, time.process_time(), 0)
        self._before = self._steps = 0

    def generation(self, *, done: Any, best: Any, evaluations: int, env_steps: int) -> None:
        """One call per chunk."""
        self._steps = self._before + env_steps
        now, used = time.monotonic(), time.process_time()
        then, used_then, steps_then = self._last
        if now - then >= self.every:
            steps = self._steps - steps_then
            self.samples.append({
                "seconds": now - self.start,
                "resident_mb": resident_mb(),
                "env_steps_per_cpu_s": steps / (used - used_then),
                "env_steps_per_s": steps / (now - then),
            })  # fmt: skip
            self._last = (now, used, self._steps)

    def next_run(self) -> None:
        """Another run counts its steps from 0."""
        self._before = self._steps


def resident_mb() -> float:
    """Resident memory of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE / 1e6


def broken(folder: Path) -> list[str]:
    """What does not hold in a finished run."""
    run, wrong = read_run(folder), []
    packets, limit = run.settings.swarm.packets, run.settings.world.time_limit
    for row in run.rows:
        place = f"seed {row['seed']}, generation {row['generation']}"
        if not 0 <= row["delivered"] <= packets or any(
            not 0 <= held <= row["delivered"] for held in row["contribution"]
        ):
            wrong.append(f"{place}: packets are not conserved")
        if not abs(row["delivered"] / packets - row["steps"] / limit - row["fitness"]) < 1e-9:
            wrong.append(f"{place}: fitness is not what was delivered and the time it took")
    bound = _greatest_quality(run.settings)
    for instance in range(run.settings.instances):
        for one in (run.best(instance), *run.members(instance)):  # reading refuses what is not finite
            if np.abs(one.quality).max() > bound or one.usage.min() < 0:
                wrong.append(
                    f"seed {one.instance_seed}, generation {one.generation}: quality or usage is out of bounds"
                )
    return wrong


def _greatest_quality(settings: Settings) -> float:
    """No reward is above that of a packet carried across the whole world in a step, by both sides of a transfer."""
    world, costs = settings.world, max(settings.learning.cost_move, settings.learning.cost_communicate)
    reach = 10 * (world.distance + settings.radio.network_range + settings.swarm.speed * world.time_limit)
    return (np.log(reach + 1) + settings.swarm.speed + costs) / (1 - settings.learning.beta_q)


def drift(samples: list[dict[str, float]], name: str) -> dict[str, float]:
    """Medians of the first and the last quarter of the samples, and their relative difference."""
    values = np.array([sample[name] for sample in samples])
    quarter = max(1, len(values) // 4)
    first, last = float(np.median(values[:quarter])), float(np.median(values[-quarter:]))
    return {"first": first, "last": last, "drift": last / first - 1, "most": float(values.max())}


def soak(settings: Settings, minutes: float, warm_up: float, every: float) -> dict[str, Any]:
    """Evolve for so long and sum up."""
    from slcs2_jax.running import driver

    sampler, wrong, runs = Sampler(every), [], 0
    while time.monotonic() - sampler.start < 60 * minutes:
        with tempfile.TemporaryDirectory(prefix="slcs2-soak-") as scratch:
            seed = settings.seed + runs * settings.instances
            driver.evolve([dataclasses.replace(settings, seed=seed, run_dir=f"{scratch}/run")], report=sampler)
            wrong += broken(Path(scratch) / "run")
        sampler.next_run()
        runs += 1
        if sampler.samples:
            last = sampler.samples[-1]
            print(f"{last['seconds']:8.0f} s  {runs} runs  {last['resident_mb']:.0f} MB", file=sys.stderr, flush=True)
    warm = [sample for sample in sampler.samples if sample["seconds"] >= 60 * warm_up]
    if len(warm) < 4:
        raise InputError(f"minutes={minutes}: {len(warm)} samples after the warm-up; accepted is a longer time")
    return {
        "minutes": minutes,
        "warm_up_minutes": warm_up,
        "runs": runs,
        "samples": len(warm),
        **{name: drift(warm, name) for name in SAMPLED},
        "broken": wrong,
        "every_sample": sampler.samples,
    }


def flat(figures: dict[str, Any]) -> bool:
    """Did memory and throughput stay where they were?"""
    return all(abs(figures[name]["drift"]) <= most for name, most in MOST_DRIFT.items())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--warm-up", type=float, default=10, help="minutes left out of the drift")
    parser.add_argument("--every", type=float, default=10, help="seconds between samples")
    parser.add_argument("--environment", default="open", help="open, jammed, urban or urban_jammed")
    parser.add_argument("--out", type=Path, help="JSON file for the figures")
    parser.add_argument("settings", nargs="*", metavar="setting=value")
    options = parser.parse_args()
    given = dict(one.split("=", 1) for one in options.settings)
    base = Settings(world=World.preset(options.environment), search=Search(generations=20, fresh_deployments=4))
    settings = changed(base, {name: json.loads(value) for name, value in given.items()})
    runtime.configure(settings.compute)
    figures = soak(settings, options.minutes, options.warm_up, options.every)
    text = json.dumps(figures, indent=2)
    if options.out:
        options.out.write_text(text + "\n", encoding="utf-8")
    print(json.dumps({name: value for name, value in figures.items() if name != "every_sample"}, indent=2))
    return 0 if flat(figures) and not figures["broken"] else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except InputError as error:
        sys.exit(f"soak: error: {error}")
