"""Results put together: what each entry came to in each kind of world. Reads files only; no JAX."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from slcs2_jax.suite import measured
from slcs2_jax.suite.bound import best_fitness
from slcs2_jax.suite.entries import ORDER
from slcs2_jax.suite.measured import Measured
from slcs2_jax.suite.statistics import Scores
from slcs2_jax.suite.worlds import Suite, SuiteWorld, seeds_of

Key = tuple[str, str]  # entry, world


@dataclass(frozen=True, eq=False)
class Table:
    """Results of entries in worlds, those that there are.

    Attributes:
        suite: whose.
        worlds: kinds of worlds that any entry was measured in, in the suite's order.
        entries: titles by name, in the suite's order, a user's own behind.
        results: by entry and world.
        bounds: the mean of the best possible fitness in the worlds of each kind.
    """

    suite: Suite
    worlds: Sequence[SuiteWorld]
    entries: Mapping[str, str]
    results: Mapping[Key, Measured]
    bounds: Mapping[str, float]
    _scores: dict[Key, Scores] = field(default_factory=dict)

    def scores(self, entry: str, world: str) -> Scores:
        """Mean fitness in each test world, over trainings and deployments: float64 [S], in the order of the seeds."""
        key = entry, world
        if key not in self._scores:
            one = self.results[key]
            every = one.fitness(self.suite.worlds[world]).mean(axis=(0, 2))
            self._scores[key] = every[np.argsort(one.seeds)]
        return self._scores[key]

    def paired(self, first: str, second: str, world: str) -> tuple[Scores, Scores]:
        """Scores of two entries in the test worlds that both were in."""
        seeds = [np.sort(self.results[one, world].seeds) for one in (first, second)]
        common = np.intersect1d(seeds[0], seeds[1])
        a, b = (self.scores(one, world)[np.isin(of, common)] for one, of in zip((first, second), seeds, strict=True))
        return a, b

    def common_worlds(self, *entries: str) -> list[str]:
        """The kinds of worlds that all of these were measured in."""
        return [one.name for one in self.worlds if all((entry, one.name) in self.results for entry in entries)]

    @property
    def complete(self) -> list[str]:
        """Entries that were in every kind of world; over fewer, nothing is said of all worlds."""
        return [name for name in self.entries if len(self.common_worlds(name)) == len(self.suite.worlds)]


def collect(
    suite: Suite,
    roots: Sequence[Path],
    worlds: Sequence[SuiteWorld],
    *,
    only: Sequence[str] = (),
    seeds: int | None = None,
    split: str = "test",
) -> Table:
    """What these folders hold, the first before the others.

    only: of these entries alone, if any are named. seeds: of so many worlds of each kind alone, the first ones.
    split: test or validation.

    Raises InputError naming a damaged file, or one of other worlds.
    """
    names = dict.fromkeys([*ORDER, *(name for root in roots for name in measured.entries_in(root, split))])
    wanted = [name for name in names if not only or name in only]
    results = {}
    for name in wanted:
        for world in worlds:
            found = measured.find(name, world, roots, split)
            found = found if found is None or seeds is None else within(found, seeds_of(world, split, seeds))
            if found is not None:
                results[name, world.name] = found
    titles = {entry: one.title for (entry, _), one in results.items()}
    there = [world for world in worlds if any(key[1] == world.name for key in results)]
    bounds = {world.name: float(best_fitness(world, split).mean()) for world in there}
    return Table(suite, there, titles, results, bounds)


def within(result: Measured, seeds: Sequence[int]) -> Measured | None:
    """The same of these test worlds alone; None if it was in none of them."""
    kept = np.isin(result.seeds, seeds)
    if not kept.any():
        return None
    delivered, steps = result.delivered[:, kept], result.steps[:, kept]
    return dataclasses.replace(result, seeds=result.seeds[kept], delivered=delivered, steps=steps)
