"""An experiment's or a sweep's results, made comparable: the same instances and generations for every arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from slcs2_jax.config.field import refuse
from slcs2_jax.config.model import ENVIRONMENTS
from slcs2_jax.results.arm import CELLS, OVERALL, PLACES, PLAIN, Cell, arm_title, ordered
from slcs2_jax.study.collect import Outcome
from slcs2_jax.study.factor import Factor, factors
from slcs2_jax.study.statistics import Comparison, Description, Values, compare, describe, holm

BEST, FRESH = "best", "fresh"
METRICS = {FRESH: "winner's mean over fresh deployments", BEST: "best fitness of the search"}  # fresh means decide
MOST_ARMS = 6  # that one figure tells apart
GENERATION = "generation"
SPENT = (GENERATION, "episodes", "env-steps")  # what a search is looked at by
_LOOKS = 200  # at curves by episodes or env-steps
SWEEP = "sweep"  # name of the study of runs that differ in settings


class Contest(NamedTuple):
    """An arm against the reference somewhere."""

    arm: str
    place: Cell


@dataclass(frozen=True, eq=False, kw_only=True)
class Study:
    """What an experiment found, so far as it can be compared.

    Attributes:
        name, title: of the experiment.
        arms: in the order of tables; the reference first.
        generations: after so many every evolved arm is looked at; 0 if none evolves or none has begun.
        to_end: searches stop by their episodes: each is looked at where it ended, and `generations` is the most.
        outcomes: all results of the arms, comparable or not.
        missing: in words, what is planned or in other arms and not here.
        factors: settings in which its arms differ, of a sweep; an arm counts there only in the worlds where it has
            results.
    """

    name: str
    title: str
    arms: tuple[str, ...]
    generations: int
    outcomes: tuple[Outcome, ...]
    missing: tuple[str, ...]
    factors: tuple[Factor, ...] = ()
    to_end: bool = False

    @property
    def when(self) -> str:
        """At which moment of their searches arms are compared."""
        return "where each search ended" if self.to_end else f"after {self.generations} generations"

    @property
    def reference(self) -> str:
        """The arm that the others are compared with."""
        return self.arms[0]

    def seeds(self, cell: Cell, metric: str) -> tuple[int, ...]:
        """Run of which every arm has this figure."""
        return self._shared[metric].get(cell, ())

    def instances(self, arm: str, place: Cell, metric: str) -> list[tuple[int, float]]:
        """Seed and figure of each instance, in the order of `seeds`; overall: of the first of each of a range's cells.

        These are as many of each cell as every cell has, so that all count alike. Overall is empty unless every type of
        the range has results: it is never of fewer worlds.
        """
        cells = [place]
        if place.environment == OVERALL:
            cells = [Cell(environment, place.range) for environment in ENVIRONMENTS]
        shared = [self.seeds(cell, metric) if self.figures(arm, cell, metric) else () for cell in cells]
        count = min(map(len, shared))
        pairs = [(cell, seed) for cell, seeds in zip(cells, shared, strict=True) for seed in seeds[:count]]
        return [(seed, self.figures(arm, cell, metric)[seed]) for cell, seed in pairs]

    def sample(self, arm: str, place: Cell, metric: str) -> Values:
        """An arm's independent figures in a place: one for each seed.

        Cells that share a seed share start positions and buildings, so overall the mean over them counts once.
        """
        by_seed: dict[int, list[float]] = {}
        for seed, figure in self.instances(arm, place, metric):
            by_seed.setdefault(seed, []).append(figure)
        return np.array([np.mean(own) for own in by_seed.values()], dtype=np.float64)

    def figures(self, arm: str, cell: Cell, metric: str) -> dict[int, float]:
        """An arm's figures in a cell by seed, shared with other arms or not."""
        return self._figures[metric].get((arm, cell), {})

    def descriptions(self, metric: str) -> dict[tuple[str, Cell], Description]:
        """Every arm in every place that has results."""
        return self._described[metric]

    def comparisons(self, metric: str) -> dict[Contest, Comparison]:
        """Every arm against the reference in every place; above 0 means that the reference is better.

        Holm's families: all cells of the experiment, and all of its overall figures.
        """
        return self._compared[metric]

    def looks(self, cell: Cell, by: str = GENERATION) -> Values:
        """Where the searches of a cell are looked at, one of `SPENT`, in ascending order.

        By generation each; else evenly, from where each has a figure to what each of them has spent: generations cost
        more or fewer episodes, as solutions are deployed again.
        """
        if by == GENERATION:
            return np.arange(1.0, self.generations + 1)
        spent = [_spent(one, by)[: self.generations] for one in self._compared_outcomes(cell) if one.evolves]
        first = max((one[0] for one in spent), default=0.0)
        return np.linspace(first, max(first, min((one[-1] for one in spent), default=0.0)), _LOOKS)

    def curves(self, arm: str, cell: Cell, by: str = GENERATION) -> Values:
        """float64[instances, looks]: best so far; one figure throughout of a behaviour that does not evolve, and of a
        search that has ended."""
        looks = self.looks(cell, by)
        by_seed = {one.seed: one for one in self._compared_outcomes(cell) if one.arm == arm}
        curves = []
        for seed in self.seeds(cell, BEST) if by_seed else ():
            one = by_seed[seed]
            if one.evolves:
                curves.append(one.curve[np.searchsorted(_spent(one, by), looks, side="right") - 1])
            else:
                curves.append(np.full(len(looks), self.figures(arm, cell, BEST)[seed]))
        return np.array(curves, dtype=np.float64)

    def _compared_outcomes(self, cell: Cell) -> list[Outcome]:
        """Those with a figure, of the seeds that are compared."""
        seeds = self.seeds(cell, BEST)
        here = [one for one in self.outcomes if one.cell == cell and one.seed in seeds]
        return [one for one in here if one.seed in self.figures(one.arm, cell, BEST)]

    def failed_deployments(self, arm: str, cell: Cell) -> float | None:
        """Share of single fresh deployments, of an evolved winner or another behaviour, that delivered nothing.

        Over the instances that every arm has; None where one of them has not kept it.
        """
        by_seed = {one.seed: one.failed for one in self.outcomes if (one.arm, one.cell) == (arm, cell)}
        shares = [by_seed.get(seed) for seed in self.seeds(cell, FRESH)] if by_seed else []
        known = [share for share in shares if share is not None]
        return sum(known) / len(known) if known and len(known) == len(shares) else None

    @cached_property
    def _figures(self) -> dict[str, dict[tuple[str, Cell], dict[int, float]]]:
        found: dict[str, dict[tuple[str, Cell], dict[int, float]]] = {BEST: {}, FRESH: {}}
        at = None if self.to_end else self.generations
        for one in self.outcomes:
            for metric, value in ((BEST, one.best(at)), (FRESH, one.fresh_after(at))):
                if value is not None:
                    found[metric].setdefault((one.arm, one.cell), {})[one.seed] = value
        return found

    @cached_property
    def _shared(self) -> dict[str, dict[Cell, tuple[int, ...]]]:
        shared: dict[str, dict[Cell, tuple[int, ...]]] = {}
        for metric in METRICS:
            shared[metric] = {}
            for cell in CELLS:
                seeds = [set(self.figures(arm, cell, metric)) for arm in self.arms]
                if self.factors:
                    seeds = [own for own in seeds if own]
                shared[metric][cell] = tuple(sorted(set.intersection(*seeds))) if seeds else ()
        return shared

    @cached_property
    def _described(self) -> dict[str, dict[tuple[str, Cell], Description]]:
        def described(metric: str) -> dict[tuple[str, Cell], Description]:
            samples = {(arm, place): self.sample(arm, place, metric) for place in PLACES for arm in self.arms}
            return {key: describe(sample) for key, sample in samples.items() if len(sample)}

        return {metric: described(metric) for metric in METRICS}

    @cached_property
    def _compared(self) -> dict[str, dict[Contest, Comparison]]:
        return {metric: self._compare(metric) for metric in METRICS}

    def _compare(self, metric: str) -> dict[Contest, Comparison]:
        found: dict[Contest, Comparison] = {}
        for overall in (False, True):
            family = [
                Contest(arm, place)
                for arm in self.arms[1:]
                for place in PLACES
                if (place.environment == OVERALL) == overall
                and len(self.sample(arm, place, metric))
                and len(self.sample(self.reference, place, metric))
            ]
            pairs = [
                compare(self.sample(self.reference, contest.place, metric), self.sample(*contest, metric))
                for contest in family
            ]
            found |= dict(zip(family, holm(pairs), strict=True))
        return found


def _spent(one: Outcome, by: str) -> Values:
    """What a search had spent by each of its generations."""
    if by == GENERATION:
        return np.arange(1.0, len(one.curve) + 1)
    return one.episodes if by == "episodes" else one.steps


def studies(
    outcomes: Sequence[Outcome], experiments: Mapping[str, tuple[str, Sequence[str]]], generations: int | None = None
) -> list[Study]:
    """A study for every experiment of which the reference and another arm are there, and one for what is left.

    If runs differ in other settings than algorithms do, the experiments' are those with none of these changed, and
    all together are the study of a sweep.

    Args:
        outcomes: all results of a folder.
        experiments: by name, title and arms (the reference first).
        generations: after so many, instead of the most that all runs of the experiment share.

    Raises:
        InputError: no run has so many generations.
    """
    most = max(len(one.curve) for one in outcomes)
    if generations is not None and not 1 <= generations <= most:
        raise refuse("generations", generations, f"a whole number from 1 to {most}, the most that a run here has")
    present = {one.arm for one in outcomes}
    left = set(present)
    found = []
    for name, (title, arms) in experiments.items():
        own = [arm for arm in arms if arm in present]
        if arms[0] in present and len(own) > 1:
            found.append(_study(name, title, own, outcomes, generations))
            left -= set(own)
    if varied := factors(one.settings for one in outcomes):
        title = "Sweep over " + ", ".join(one.name for one in varied)
        found.append(_study(SWEEP, title, _sweep_arms(outcomes, varied), outcomes, generations, varied))
    elif left:
        reference = [PLAIN] if PLAIN in present - left else []
        found.append(_study("runs", "All runs", [*reference, *ordered(left)], outcomes, generations))
    return found


def _sweep_arms(outcomes: Sequence[Outcome], varied: Sequence[Factor]) -> list[str]:
    """Those that have begun: each algorithm unchanged, then with one setting changed, with two, ..."""
    algorithms = ordered(one.algorithm for one in outcomes)
    order = {one.name: (place, one.values) for place, one in enumerate(varied)}

    def place(one: Outcome) -> tuple[int, int, list[tuple[int, int]]]:
        steps = [(order[name][0], order[name][1].index(value)) for name, value in one.point]
        return algorithms.index(one.algorithm), len(steps), steps

    begun = [one for one in outcomes if not _not_begun(one)]
    return list(dict.fromkeys(one.arm for one in sorted(begun, key=place)))


def _study(
    name: str,
    title: str,
    arms: Sequence[str],
    outcomes: Sequence[Outcome],
    generations: int | None,
    varied: tuple[Factor, ...] = (),
) -> Study:
    own = tuple(one for one in outcomes if one.arm in arms)
    to_end = generations is None and any(one.settings.search.episodes is not None for one in own if one.evolves)
    count = generations if generations is not None else _shared_generations(arms, own)
    if to_end:
        count = max(len(one.curve) for one in own)
    return Study(
        name=name,
        title=title,
        arms=tuple(arms),
        generations=count,
        outcomes=own,
        missing=tuple(_missing(arms, own, None if to_end else count, worlds=not varied)),
        factors=varied,
        to_end=to_end,
    )


def _shared_generations(arms: Sequence[str], outcomes: Sequence[Outcome]) -> int:
    """The most that all runs have which have begun, in the cells that every arm has begun; 0 if none evolves."""
    begun = [one for one in outcomes if not _not_begun(one)]
    places = {(one.arm, one.cell) for one in begun}
    shared = {cell for cell in CELLS if all((arm, cell) in places for arm in arms)}
    return min((len(one.curve) for one in begun if one.evolves and (one.cell in shared or not shared)), default=0)


def _missing(arms: Sequence[str], outcomes: Sequence[Outcome], generations: int | None, *, worlds: bool) -> list[str]:
    """What keeps the comparison from being whole, each in a line; `worlds`: the paper's eight belong to it."""
    lines: list[str] = []
    by_place = {(one.arm, one.cell, one.seed): one for one in outcomes}
    cells = [cell for cell in CELLS if any(one.cell == cell for one in outcomes)]
    absent = [cell.title for cell in CELLS if cell not in cells]
    if absent and worlds:
        lines.append(f"no runs at all: {', '.join(absent)}")
    for arm in arms:
        for cell in cells:
            seeds = sorted({one.seed for one in outcomes if one.cell == cell})
            found = {seed: by_place.get((arm, cell, seed)) for seed in seeds}
            where = f"{arm_title(arm)}, {cell.title}"
            lines += _told(where, "no run", [seed for seed, one in found.items() if one is None], len(seeds))
            here = [one for one in found.values() if one is not None]
            lines += _unfinished(where, here, generations, len(seeds))
    return lines


def _unfinished(where: str, outcomes: Sequence[Outcome], generations: int | None, of: int) -> list[str]:
    lines = _told(where, "not begun", [one.seed for one in outcomes if _not_begun(one)], of)
    if generations is None:
        going = [one.seed for one in outcomes if not _not_begun(one) and one.fresh_after(None) is None]
        return lines + _told(where, "not ended", going, of)
    short = [one for one in outcomes if one.evolves and 0 < len(one.curve) < one.planned]
    if short:
        fewest, most = min(len(one.curve) for one in short), max(len(one.curve) for one in short)
        count = str(fewest) if fewest == most else f"{fewest} to {most}"
        planned = max(one.planned for one in short)
        lines += _told(where, f"{count} of {planned} generations", [one.seed for one in short], of)
    unmeasured = [
        one.seed
        for one in outcomes
        if not _not_begun(one) and one not in short and one.fresh_after(generations) is None
    ]
    return lines + _told(where, f"no fresh deployments after generation {generations}", unmeasured, of)


def _not_begun(one: Outcome) -> bool:
    return not len(one.curve) if one.evolves else not len(one.deployments)


def _told(where: str, what: str, seeds: Sequence[int], of: int) -> list[str]:
    if not seeds:
        return []
    which = "all seeds" if len(seeds) == of else f"seed{'s' * (len(seeds) > 1)} {', '.join(map(str, seeds))}"
    return [f"{where}: {what} ({which})"]
