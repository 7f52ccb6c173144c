"""Do searches by XLA and by the native chunk come to the same? Runs both in every kind of world and compares.

python scripts/native_agreement.py OUT [instances=16] [generations=20] [ranges=short,long] [seed=0]

Each world is evolved twice with the same seeds, compute.native=off and on; what is there already in OUT is not computed
again. The best fitness of every instance is compared by Mann-Whitney U, two-sided; the p-values of all worlds are
adjusted by Holm; the difference of the means is given with its 95 % interval (Welch). Exits with 1 if any p < 0.05.
"""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
from scipy import stats
from statsmodels.stats.multitest import multipletests

from slcs2_jax import evolve
from slcs2_jax.config import Settings, World

ENVIRONMENTS = ("open", "jammed", "urban", "urban_jammed")
ENGINES = ("off", "on")


def best(folder: Path, settings: Settings) -> np.ndarray:
    """Best fitness of every instance, computed unless the folder holds it."""
    [summary] = evolve(dataclasses.replace(settings, run_dir=str(folder)))
    return np.array([one.best_fitness for one in summary.instances])


def settings_of(environment: str, range_: str, engine: str, options: dict[str, int]) -> Settings:
    """Of a run."""
    base = Settings(world=World.preset(environment, range_), instances=options["instances"], seed=options["seed"])
    return dataclasses.replace(
        base,
        search=dataclasses.replace(base.search, generations=options["generations"], fresh_deployments=1),
        compute=dataclasses.replace(base.compute, native=engine),
    )


def main(arguments: list[str]) -> int:
    """Run, print a table, and tell whether all worlds agree."""
    if not arguments or arguments[0].startswith("-"):
        print(__doc__)
        return 2
    out, options, ranges = Path(arguments[0]), {"instances": 16, "generations": 20, "seed": 0}, ["short", "long"]
    for argument in arguments[1:]:
        name, _, value = argument.partition("=")
        if name == "ranges":
            ranges = value.split(",")
        else:
            options[name] = int(value)
    rows = []
    for environment in ENVIRONMENTS:
        for range_ in ranges:
            name = f"{environment}/{range_}"
            xla, native = (
                best(out / f"{environment}_{range_}_{engine}", settings_of(environment, range_, engine, options))
                for engine in ENGINES
            )
            p = float(stats.mannwhitneyu(xla, native).pvalue)
            interval = stats.ttest_ind(native, xla, equal_var=False).confidence_interval()
            rows.append((name, xla.mean(), native.mean(), interval.low, interval.high, p))
            print(f"{name}: XLA {xla.mean():.3f}, native {native.mean():.3f}, p {p:.3f}", flush=True)
    adjusted = multipletests([row[-1] for row in rows], method="holm")[1]
    print("\n| world | XLA | native | difference, 95 % interval | p | p, Holm |\n|---|--:|--:|--:|--:|--:|")
    for (name, xla, native, low, high, p), holm in zip(rows, adjusted, strict=True):
        difference = f"{native - xla:+.3f} [{low:+.3f}, {high:+.3f}]"
        print(f"| {name} | {xla:.3f} | {native:.3f} | {difference} | {p:.3f} | {holm:.3f} |")
    return int(bool((adjusted < 0.05).any()))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
