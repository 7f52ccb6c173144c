"""The least time in which the packets could reach the sink: a relaxation, from speed, distances and links alone.

Walls, jammers, noise, interference, failures and all ignorance are left out. What is kept:

- a packet reaches the sink from an agent that is within net of it; before the first one does, some agent must have gone
  there from its start at full speed;
- in a time-step the sink takes at most one packet on each channel, and an agent, which holds one packet at a time,
  can hand one over in every second step at most.

A link longer than net may succeed by fading, which this leaves out; so the bound is that of the mean radio.
"""

from __future__ import annotations

import math

import numpy as np

from slcs2_jax.suite.worlds import SuiteWorld


def least_time(starts: np.ndarray, sink: np.ndarray, *, packets: int, speed: float, net: float, channels: int) -> int:
    """Time-steps that no swarm can do with less of.

    Args:
        starts: float [n, 2], m.
        sink: float [2], m; the source is the origin.
        packets: p.
        speed: m per step.
        net: m, reach of a link.
        channels: that the sink can receive on at once.
    """
    nearest = float(np.hypot(*(np.asarray(starts, np.float64) - sink).T).min())
    walk = max(0, math.ceil((nearest - net) / speed))
    first = walk + 2  # it collects in one step, and sends in another
    rate = min(float(channels), len(starts) / 2)
    return first + math.ceil((packets - 1) / rate)


def best_fitness(world: SuiteWorld, split: str = "test") -> np.ndarray:
    """The fitness of `least_time` in every world of a split: float64 [S]."""
    found = []
    for seed in world.seeds_of(split):
        settings, scenario = world.settings(seed), world.scenario(seed)
        steps = least_time(
            scenario.start,
            scenario.sink,
            packets=settings.swarm.packets,
            speed=settings.swarm.speed,
            net=settings.radio.network_range,
            channels=len(settings.radio.channels),
        )
        found.append(1 - steps / scenario.time_limit)
    return np.array(found)
