"""Small runs in all worlds by one library, in a process of its own: LIBRARY DEVICES FOLDER are its arguments."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

from slcs2_jax import evolve
from slcs2_jax.config import Compute, Jammers, Radio, Rules, Search, Settings, Swarm, World
from slcs2_jax.native import library

ENVIRONMENTS = ("open", "jammed", "urban", "urban_jammed")


def runs(devices: int) -> dict[str, Settings]:
    """The eight worlds, each a few generations, and one with everything that is not the paper's."""
    found = {}
    for environment in ENVIRONMENTS:
        for range_, grammar in (("short", "main"), ("long", "both")):
            world = dataclasses.replace(World.preset(environment, range_), time_limit=1000)
            found[f"{environment}_{range_}"] = Settings(
                world=world,
                rules=Rules(rules=40, grammar=grammar),
                search=Search(generations=3, fresh_deployments=1),
                compute=Compute(devices=devices, native="on"),
                instances=2,
            )
    found["other_parts"] = dataclasses.replace(
        found["urban_jammed_short"],
        jammers=Jammers(count=2, motion="pursue", emission="sweeping"),
        radio=Radio(fading="nakagami", channels=(1, 6, 11, 14)),
        swarm=Swarm(failure_rate=0.001, recovery_steps=50.0, failures_at=(100,)),
    )
    return found


def main(path: str, devices: str, folder: str) -> None:
    """Leaves a run folder for each."""
    library._find = lambda: Path(path)  # the one that is asked for
    made = runs(int(devices))
    evolve(*(dataclasses.replace(run, run_dir=str(Path(folder) / name)) for name, run in made.items()))


if __name__ == "__main__":
    main(*sys.argv[1:])
