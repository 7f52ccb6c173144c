"""The benchmark in a world of seconds, with folders that slcs2 suite and slcs2 transfer leave, for the campaign:

    python scripts/fault_campaign_suite.py ARGUMENT ...

is slcs2 with that suite in the place of the frozen one.
"""

from __future__ import annotations

import dataclasses
import functools
import shutil
import sys
from pathlib import Path

import fault_campaign_given as given
import numpy as np

from slcs2_jax.cli import main
from slcs2_jax.results.policy_file import save_policy
from slcs2_jax.suite import measured, worlds
from slcs2_jax.suite.worlds import Suite

WORLD = "few"
NAMES = ("mine.yaml", "net.yaml", "list.txt", "walk.npz", "ppo.yaml", "raced.yaml")
SEARCH, STRATEGY, LIST, WALK, IPPO, RACED = (f"entries/{name}" for name in NAMES)
ENTRIES = (SEARCH, STRATEGY, LIST, WALK)
TEXTS = {
    SEARCH: "title: Mine\nabout: A search.\nsettings: {rules: {rules: 6}}\n",
    STRATEGY: "algorithm: strategy\nsettings: {strategy: {population: 4}, network: {hidden: [4]}}\n",
    IPPO: "algorithm: ippo\nsettings: {ippo: {episodes: 2, chunk: 50, unroll: 10, minibatches: 1}, "
    "network: {hidden: [4]}}\n",
    RACED: "settings: {acceptance: best, search: {name: informed, parent: tournament, starts: 2, "
    "inherit_quality: true, racing: true, final_every: 20}, knowledge: {mode: reflex}, rules: {rules: 40}}\n",
    LIST: "# List: of two rules\npacket held => move toward sink\nno packet held => move toward source\n",
}
# what training and evaluating leave below their folder
ARTEFACTS = tuple(f"artefacts/{name}/{WORLD}/training_0.npz" for name in ("mine", "net"))
RECORDS = tuple(file.replace(".npz", ".json") for file in ARTEFACTS)
RESULTS = tuple(f"{folder}/mine/{WORLD}.npz" for folder in ("results", "validation"))
RUN, NET = (f"runs/{name}/{WORLD}/training_0" for name in ("mine", "net"))
NET_CHECKPOINT, NET_CURVE, NET_POLICY = (f"{NET}/{name}" for name in ("checkpoint.npz", "curve.jsonl", "policy.npz"))
TRAINING = (NET_CHECKPOINT, NET_CURVE, NET_POLICY, f"{NET}/lock", f"{RUN}/config.yaml", f"{RUN}/checkpoint.npz")
KEPT = (*ENTRIES, *ARTEFACTS, *RECORDS, *RESULTS)
FOLDERS_KEPT = ("artefacts", "artefacts/mine", f"artefacts/net/{WORLD}", "results", "results/mine", "validation")
FOLDERS_TRAINING = ("runs", f"runs/mine/{WORLD}", RUN, NET)


@functools.lru_cache(maxsize=1)
def small_suite() -> Suite:
    """One kind of worlds, one training of a few episodes."""
    full = worlds.load_suite()
    stated = {"world.distance": 120.0, "world.time_limit": 150, "swarm.packets": 3, "swarm.agents": 3}
    stated |= {"checkpoint.seconds": 0.2}
    world = full.worlds[WORLD]
    small = dataclasses.replace(
        world,
        stated=world.stated | stated,
        seeds={split: (first, 2) for split, (first, _) in world.seeds.items()},
        files={},
        trainings=1,
        env_steps=8 * 150,
    )
    return dataclasses.replace(full, worlds={WORLD: dataclasses.replace(small, sha256=small.found)}, deployments=1)


def use_small_suite() -> None:
    """In this process: commands find the small suite, and no results that come with the frozen one."""
    suite = small_suite()
    worlds.load_suite = lambda: suite  # type: ignore[assignment]
    measured.shipped_root = lambda: Path("nothing-comes-with-it")


def write_entries(root: Path) -> None:
    """A search, two networks, a decision list and a policy, that take part by their files."""
    (root / "entries").mkdir(parents=True)
    for name, text in TEXTS.items():
        (root / name).write_text(text)
    save_policy(root / WALK, given.NAME, {"action": np.zeros(1, np.int32)})


def make_suites(good: Path) -> int:
    """`trained`: trained and evaluated; `training`: the runs are there, and nothing was chosen yet."""
    use_small_suite()
    write_entries(good / "trained")
    called = commands(good / "trained", good)
    evaluate = called["suite evaluate"]
    for arguments in (called["suite train"], evaluate, [*evaluate, "split=validation"]):
        if code := main(arguments):
            return code
    shutil.copytree(good / "trained", good / "training")
    for name in ("artefacts", "results", "validation"):
        shutil.rmtree(good / "training" / name)
    return 0


def commands(root: Path, scratch: Path) -> dict[str, list[str]]:
    """What is called on the folder of a suite."""
    both = f"{root / SEARCH},{root / STRATEGY}"
    every = f"{both},{root / LIST},{root / WALK}"
    rest = [f"run_dir={root}", f"world={WORLD}"]
    machine = ["compute.devices=1"]
    return {
        "suite train": ["suite", "train", both, *rest, *machine],
        "suite evaluate": ["suite", "evaluate", every, *rest, *machine],
        "suite table": ["suite", "table", *rest],
        "suite validation": ["suite", "table", "split=validation", f"out={scratch}", *rest],
        "suite replay": [
            "replay", str(root / SEARCH), f"beside={root / STRATEGY}", f"suite={WORLD}", f"run_dir={root}",
            "picture=paths", f"out={scratch}/paths.png", *machine,
        ],
    }  # fmt: skip


if __name__ == "__main__":
    use_small_suite()
    sys.exit(main())
