"""The serial peers: the tests' oracle as plain Python, and compiled by Numba on one core and on all.

They play the same episodes as the batch: the same scenarios, rules and keys, from the first step on.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np

from benchmarks.rounds import Play, clock
from benchmarks.workload import Workload
from slcs2_jax.world.scenario import Scenario
from tests.oracle import compiled, episode
from tests.oracle.inputs import make_params, make_rules, make_world
from tests.oracle.model import Params, Rules, State, World, new_state, new_work

STRETCHES = 10  # plain Python plays as many short stretches, evenly spread over an episode


@dataclass(frozen=True, eq=False)
class Peers:
    """Some episodes as the oracle takes them."""

    params: Params
    worlds: Sequence[World]
    rules: Sequence[Rules]
    keys: np.ndarray  # uint32[E, 2]
    fastmath: bool

    @classmethod
    def of(cls, workload: Workload, episodes: int, *, fastmath: bool) -> Peers:
        """The workload's first episodes."""
        settings = workload.settings
        jobs = [workload.job(number) for number in range(episodes)]
        used = [channel in workload.channels for channel in range(3)]
        return cls(
            params=make_params(settings.radio, settings.swarm, settings.learning, settings.world.wall_thickness),
            worlds=[_world(job.scenario) for job in jobs],
            rules=[make_rules(job.given.mask, job.given.action, used) for job in jobs],
            keys=np.array([job.key for job in jobs]),
            fastmath=fastmath,
        )

    def compile(self) -> tuple[float, float]:
        """Get what is compiled, from the compiler or Numba's cache; seconds for one core, and more for all."""
        short = dataclasses.replace(self, worlds=[world._replace(time_limit=1) for world in self.worlds])
        return short.one_core().seconds, short.all_cores().seconds

    def one_core(self) -> Play:
        """All episodes, one after the other."""
        start = clock.now()
        lengths = [
            compiled.run_episode(world, rules, self.params, *self._key(e), fastmath=self.fastmath).steps
            for e, (world, rules) in enumerate(zip(self.worlds, self.rules, strict=True))
        ]
        return _play(clock.now() - start, lengths)

    def all_cores(self) -> Play:
        """All episodes, handed one by one to whichever thread is free."""
        with numba.parallel_chunksize(1):
            start = clock.now()
            out = compiled.run_many(list(self.worlds), list(self.rules), self.params, self.keys, fastmath=self.fastmath)
            seconds = clock.now() - start
        return _play(seconds, np.asarray(out.steps).tolist())

    def stretches(self, steps: int) -> list[tuple[int, State]]:
        """Where the first episode stands at evenly spread times, as far as it goes: (time, state)."""
        world, rules = self.worlds[0], self.rules[0]
        library = compiled.library(fastmath=self.fastmath)
        times = np.linspace(0, world.time_limit - steps, STRETCHES).astype(int).tolist()
        state, work = new_state(world, rules, self.params), new_work(world, rules)
        found: list[tuple[int, State]] = []
        for t in range(times[-1] + 1):
            if library.is_over(state, world, self.params, t):
                break
            if t in times:
                found.append((t, State(*(array.copy() for array in state))))
            library.step(state, world, rules, self.params, *self._key(0), t, work)
        return found

    def plain_python(self, stretches: Sequence[tuple[int, State]], steps: int) -> Play:
        """So many steps from each of the states, one scenario at a time."""
        world, rules = self.worlds[0], self.rules[0]
        seconds, made = 0.0, 0
        for first, found in stretches:
            state, work = State(*(array.copy() for array in found)), new_work(world, rules)
            start = clock.now()
            for t in range(first, first + steps):
                if episode.is_over(state, world, self.params, t):
                    break
                episode.step(state, world, rules, self.params, *self._key(0), t, work)
                made += 1
            seconds += clock.now() - start
        return Play(seconds, made, made, ())

    def _key(self, e: int) -> tuple[int, int]:
        return int(self.keys[e, 0]), int(self.keys[e, 1])


def _play(seconds: float, lengths: list[int]) -> Play:
    return Play(seconds, sum(lengths), sum(lengths), tuple(lengths))


def _world(scenario: Scenario) -> World:
    return make_world(
        start=scenario.start,
        sink=scenario.sink,
        sink_estimate=scenario.sink_estimate,
        jammer=scenario.jammer,
        vertical=scenario.vertical,
        horizontal=scenario.horizontal,
        time_limit=scenario.time_limit,
    )
