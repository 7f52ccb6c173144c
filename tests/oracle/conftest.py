"""Worlds, rules and states for the tests of the oracle."""

from types import SimpleNamespace

import numpy as np
import pytest

from slcs2_jax.config import Learning, Radio, Swarm
from tests.oracle import inputs, model

COMPARISONS = tuple(range(5, 80))
MAIN = (tuple(range(5)) + COMPARISONS, (*range(21), 22, *range(28, 57, 6)), (True, False, False))
BOTH = (tuple(range(97)), tuple(range(57)), (True, True, True))


def random_rules(seed, agents=4, count=20, grammar=MAIN, clauses=3):
    """Rules with one to `clauses` clauses and an action each."""
    rng = np.random.default_rng(seed)
    vocabulary, actions, channels = grammar
    mask = np.zeros((agents, count, 4), np.uint32)
    for i in range(agents):
        for r in range(count):
            for k in rng.choice(vocabulary, rng.integers(1, clauses + 1)):
                mask[i, r, k // 32] |= np.uint32(1 << (int(k) % 32))
    return inputs.make_rules(mask, rng.choice(actions, (agents, count)), channels)


def random_walls(rng, distance, buildings):
    """Vertical and horizontal walls of buildings in the strip between source and sink, none near the source."""
    walls = ([], [])
    for _ in range(buildings):
        x, y = rng.uniform(25, distance - 25), rng.uniform(-60, 60)
        wide, deep = rng.uniform(5, 15, 2)
        for rows, centre, half, low, high in (
            (walls[0], x, wide, y - deep, y + deep),
            (walls[1], y, deep, x - wide, x + wide),
        ):
            rows += [(centre + side * half, low, high) for side in (-1, 0, 1) if rng.random() < 0.5]
    return walls


def random_world(seed, agents=4, urban=False, jammed=False, distance=120.0, time_limit=60):
    """A small world; the agents start in a row left of the source, the walls are to its right."""
    rng = np.random.default_rng(seed)
    vertical, horizontal = random_walls(rng, distance, 6) if urban else ((), ())
    vertical = [row for row in vertical if row[0] > 5]
    horizontal = [row for row in horizontal if row[1] > 5]
    start = np.stack([-3.0 * np.arange(agents), rng.uniform(-8, 8, agents)], axis=1)
    jammer = (distance / 2, 30.0) if jammed else None
    walls = {"vertical": vertical, "horizontal": horizontal}
    return inputs.make_world(start=start, sink=(distance, 0.0), time_limit=time_limit, jammer=jammer, **walls)


def place_agents(start, sink=(600.0, 0.0), *, holding=(), params=None, rules=1, **world):
    """State, world and work of agents at given places, of which those listed in `holding` have a packet."""
    params = params or inputs.make_params(Radio(), Swarm(), Learning())
    world = inputs.make_world(start=start, sink=sink, **({"time_limit": 100} | world))
    empty = inputs.make_rules(
        np.zeros((len(world.start), rules, 4), np.uint32), np.zeros((len(world.start), rules)), (True, True, True)
    )
    state, work = model.new_state(world, empty, params), model.new_work(world, empty)
    for i in holding:
        state.holding[i] = True
        state.history[i, i] = True
        state.depot[0] -= 1
    return SimpleNamespace(state=state, world=world, work=work, rules=empty, params=params)


@pytest.fixture
def params():
    """The default configuration."""
    return inputs.make_params(Radio(), Swarm(), Learning())


@pytest.fixture
def calm():
    """The default configuration without shadowing."""
    return inputs.make_params(Radio(shadowing_db=0.0), Swarm(), Learning())


@pytest.fixture
def make():
    """The builders above."""
    return SimpleNamespace(rules=random_rules, world=random_world, place=place_agents, main=MAIN, both=BOTH)
