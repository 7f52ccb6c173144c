"""The oracle compiled by Numba: the same functions, bound to each other's compiled versions.

Numba is needed for this module only. Without `fastmath` the outcomes are those of the plain functions.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
from pathlib import Path
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import numba
import numpy as np

from slcs2_jax.grammar import vocabulary
from tests.oracle import (
    air,
    classifier,
    episode,
    geometry,
    model,
    motion,
    radio,
    randomness,
    reward,
    sensing,
    strength,
    words,
)
from tests.oracle.episode import Outcome
from tests.oracle.model import Params, Rules, Walls, World

MODULES = (words, randomness, geometry, model, radio, sensing, classifier, strength, air, motion, reward, episode)
ALLOCATING = ("new_state", "new_work", "outcome_of", "run_episode")
# What may be relaxed without assuming that no infinity or NaN occurs.
RELAXED = frozenset({"contract", "reassoc", "nsz", "arcp", "afn"})


def _digest(fastmath: bool) -> str:
    """Names a version of the compiled code: Numba's own cache watches one file at a time, and no options."""
    paths = [Path(__file__), *(Path(inspect.getfile(module)) for module in (*MODULES, vocabulary))]
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths) + bytes([fastmath])).hexdigest()[:16]


def _functions(module: ModuleType) -> dict[str, FunctionType]:
    """The functions that a module defines itself."""
    return {
        name: value
        for name, value in vars(module).items()
        if isinstance(value, FunctionType) and value.__module__ == module.__name__
    }


def _compile(function: Any, space: dict[str, Any], digest: str, **options: Any) -> Any:
    """The function with `space` for its globals, compiled when first called."""
    bound = FunctionType(function.__code__, space, function.__name__, function.__defaults__)
    bound.__qualname__ = f"{function.__name__}_{digest}"
    bound.__module__ = function.__module__
    return numba.njit(**options)(bound)


@functools.cache
def library(cache: bool = True, fastmath: bool = False) -> SimpleNamespace:
    """Every function of the oracle by name, compiled when first called; `cache` keeps the code between processes.

    `_nrt=False` takes Numba's memory management out of the step: no allocation is possible, no reference is counted.
    """
    digest = _digest(fastmath)
    options = {"cache": cache, "fastmath": set(RELAXED) if fastmath else False, "error_model": "numpy"}
    compiled: dict[str, Any] = {}
    spaces = []
    for module in MODULES:
        spaces.append(space := dict(vars(module)))
        for name, function in _functions(module).items():
            compiled[name] = _compile(function, space, digest, _nrt=name in ALLOCATING, **options)
    spaces.append(space := dict(globals()))
    space["run_episode"] = compiled["run_episode"]
    compiled["play_all"] = _compile(_play_all, space, digest, parallel=True, **options)
    for space in spaces[:-1]:
        space.update((name, function) for name, function in compiled.items() if name in space)
    return SimpleNamespace(**compiled)


def run_episode(
    world: World, rules: Rules, params: Params, key0: int, key1: int, *, cache: bool = True, fastmath: bool = False
) -> Outcome:
    """As episode.run_episode."""
    return library(cache, fastmath).run_episode(world, rules, params, int(key0), int(key1))


class Worlds(NamedTuple):
    """E worlds in one, their walls one after another (Numba's parallel loops take no tuples inside tuples)."""

    start: np.ndarray  # [E, n, 2]
    fixed: np.ndarray  # [E, 3, 2]
    sink_estimate: np.ndarray  # [E, 2]
    has_jammer: np.ndarray  # bool[E]
    time_limit: np.ndarray  # int64[E]
    vertical_end: np.ndarray  # int64[E + 1] the walls of world e are those from end[e] to end[e + 1]
    horizontal_end: np.ndarray  # int64[E + 1]


def _play_all(
    worlds, vertical, horizontal, mask, action, channels, params, keys,
    fitness, delivered, steps, contribution, quality, strengths, error, usage,
):  # fmt: skip
    """Plays all episodes in parallel. Outcomes go to plain arrays: what a parallel loop writes into tuples is lost."""
    for e in numba.prange(keys.shape[0]):
        v0, v1 = worlds.vertical_end[e], worlds.vertical_end[e + 1]
        h0, h1 = worlds.horizontal_end[e], worlds.horizontal_end[e + 1]
        world = World(
            worlds.start[e],
            worlds.fixed[e],
            worlds.sink_estimate[e],
            worlds.has_jammer[e],
            Walls(vertical.line[v0:v1], vertical.low[v0:v1], vertical.high[v0:v1]),
            Walls(horizontal.line[h0:h1], horizontal.low[h0:h1], horizontal.high[h0:h1]),
            worlds.time_limit[e],
        )
        result = run_episode(world, Rules(mask[e], action[e], channels), params, keys[e, 0], keys[e, 1])
        fitness[e] = result.fitness
        delivered[e] = result.delivered
        steps[e] = result.steps
        contribution[e] = result.contribution
        quality[e] = result.quality
        strengths[e] = result.strength
        error[e] = result.error
        usage[e] = result.usage


def _join(walls: list[Walls]) -> tuple[Walls, np.ndarray]:
    """Walls of all worlds one after another, and where those of each end, after a 0."""
    joined = Walls(*(np.concatenate(columns) for columns in zip(*walls, strict=True)))
    return joined, np.cumsum([0, *(len(w.line) for w in walls)])


def _empty_outcomes(count: int, n: int, rules: int) -> Outcome:
    """An Outcome whose fields have a leading axis [count]."""
    shapes = {"contribution": (count, n)} | dict.fromkeys(("quality", "strength", "error", "usage"), (count, n, rules))
    floats = ("fitness", "quality", "strength", "error")
    arrays: dict[str, Any] = {
        name: np.zeros(shapes.get(name, count), np.float64 if name in floats else np.int64) for name in Outcome._fields
    }
    return Outcome(**arrays)


def run_many(
    worlds: list[World],
    rules: list[Rules],
    params: Params,
    keys: np.ndarray,
    *,
    cache: bool = True,
    fastmath: bool = False,
) -> Outcome:
    """Outcome of E episodes, every field with a leading axis E, over all of Numba's threads.

    worlds[E] and rules[E] must agree in the numbers of agents and rules and in the channels; keys [E, 2] 32-bit words.
    """
    vertical, vertical_end = _join([w.vertical for w in worlds])
    horizontal, horizontal_end = _join([w.horizontal for w in worlds])
    together = Worlds(
        start=np.stack([w.start for w in worlds]),
        fixed=np.stack([w.fixed for w in worlds]),
        sink_estimate=np.stack([w.sink_estimate for w in worlds]),
        has_jammer=np.array([w.has_jammer for w in worlds]),
        time_limit=np.array([w.time_limit for w in worlds]),
        vertical_end=vertical_end,
        horizontal_end=horizontal_end,
    )
    mask, action = np.stack([r.mask for r in rules]), np.stack([r.action for r in rules])
    out = _empty_outcomes(*action.shape)
    words = np.array(keys, np.int64)
    play_all = library(cache, fastmath).play_all
    play_all(together, vertical, horizontal, mask, action, rules[0].channels, params, words, *out)
    return out
