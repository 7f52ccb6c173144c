"""How the designed behaviour does: python scripts/designed_table.py OUT [POLICY].

In each of the paper's eight worlds, in the three instances on which it was designed and in thirty others. OUT becomes a
folder with every episode (episodes.csv) and the tables (README.md). A minute or two on two cores.
"""

from __future__ import annotations

import argparse
import csv
import io
import statistics
import sys
import time
from pathlib import Path

from slcs2_jax import runtime
from slcs2_jax.config import InputError, Settings, World
from slcs2_jax.policy.decision_list import DecisionList, load_decision_list
from slcs2_jax.results import Progress
from slcs2_jax.results.arm import CELLS
from slcs2_jax.results.files import write_text
from slcs2_jax.results.run_config import versions
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.study.paper import tuning

DESIGN = {"seed": 900_001, "instances": 3, "deployments": 10}  # on which it was tuned; no experiment uses them
FRESH = {"seed": 0, "instances": 30, "deployments": 1}

Episodes = dict[str, list[list[Deployment]]]  # by cell, for each instance


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="folder for the tables")
    parser.add_argument("policy", nargs="?", default="designed", help="another decision list")
    arguments = parser.parse_args()
    decisions = load_decision_list(arguments.policy)
    runtime.configure(Settings().compute)
    start = time.perf_counter()
    episodes = {name: deploy(decisions, name, **where) for name, where in (("design", DESIGN), ("fresh", FRESH))}
    seconds = time.perf_counter() - start
    arguments.out.mkdir(parents=True, exist_ok=True)
    write_text(arguments.out / "episodes.csv", rows(episodes))
    write_text(arguments.out / "README.md", page(decisions, episodes, seconds))


def deploy(decisions: DecisionList, name: str, *, seed: int, instances: int, deployments: int) -> Episodes:
    """Every cell's episodes."""
    from slcs2_jax.running.driver import deploy_in_runs

    worlds = [World.preset(cell.environment, cell.range) for cell in CELLS]
    settings = [Settings(world=world, seed=seed, instances=instances) for world in worlds]
    with Progress(deployments, label=f"{name}: deployment") as report:
        found = deploy_in_runs(settings, decisions, deployments=deployments, report=report)
    return {cell.name: own for cell, own in zip(CELLS, found, strict=True)}


def rows(episodes: dict[str, Episodes]) -> str:
    """Every episode, as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["set", "cell", "seed", "deployment", "fitness", "delivered", "steps"])
    for (name, cells), first in zip(episodes.items(), (DESIGN["seed"], FRESH["seed"]), strict=True):
        for cell, instances in cells.items():
            for place, deployments in enumerate(instances):
                for number, one in enumerate(deployments):
                    writer.writerow([name, cell, first + place, number, one.fitness, one.delivered, one.steps])
    return text.getvalue()


def page(decisions: DecisionList, episodes: dict[str, Episodes], seconds: float) -> str:
    """The tables, as Markdown."""
    count = sum(len(own) for cells in episodes.values() for instances in cells.values() for own in instances)
    lines = [
        "# The designed behaviour",
        "",
        "Fitness where it was designed (three instances for each world, which no experiment uses), beside what the",
        "paper reports of its own, and in thirty other instances. An instance's figure is the mean of "
        f"{DESIGN['deployments']} deployments",
        f"where it was designed, and of {FRESH['deployments']} in the others; ± is the SD of the instances' figures. "
        "*Failed*: delivered nothing",
        "(fitness −1). *Stranded*: delivered some packets, but not all.",
        "",
        "| world | paper, design | design | fresh | fresh: failed | fresh: stranded |",
        "|---|---|---|---|---|---|",
    ]
    for cell in CELLS:
        paper = tuning()[cell.name]
        fresh = [one for own in episodes["fresh"][cell.name] for one in own]
        failed = sum(one.delivered == 0 for one in fresh) / len(fresh)
        stranded = sum(0 < one.delivered < Settings().swarm.packets for one in fresh) / len(fresh)
        lines.append(
            f"| {cell.title} | {paper['mean']:.3f} ± {paper['sd']:.3f} | {figure(episodes['design'][cell.name])} "
            f"| {figure(episodes['fresh'][cell.name])} | {failed:.1%} | {stranded:.1%} |"
        )
    lines += [
        "",
        f"Made by `python scripts/designed_table.py docs/results/designed`: {count:,} episodes in {seconds:.0f} s; "
        + ", ".join(f"{name} {version}" for name, version in versions().items())
        + ".",
        "One world: `slcs2 evaluate policy=designed environment=urban range=long instances=30`.",
        "",
        f"`{decisions.name}`:",
        "",
        "```text",
        decisions.text.rstrip(),
        "```",
        "",
    ]
    return "\n".join(lines)


def figure(instances: list[list[Deployment]]) -> str:
    means = [statistics.fmean(one.fitness for one in own) for own in instances]
    return f"{statistics.fmean(means):.3f} ± {statistics.stdev(means):.3f}"


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"designed_table: error: {error}")
