"""Users' tasks and rewards that give what is no number are named in one line."""

import dataclasses

import jax.numpy as jnp
import pytest

from slcs2_jax.config import InputError, Rules, Search, Settings, Swarm, Task, World
from slcs2_jax.running import driver
from slcs2_jax.swarm.task import Delivery
from tests.builders import registered

SMALL = {
    "world": World(distance=200.0, time_limit=40),
    "swarm": Swarm(agents=3, packets=2),
    "rules": Rules(rules=8),
    "search": Search(generations=1, fresh_deployments=1),
    "instances": 1,
}


@dataclasses.dataclass(frozen=True)
class Endless:
    """A reward that is not finite."""

    def __call__(self, view, after, outcome):
        return jnp.full_like(view.x, jnp.nan)


@dataclasses.dataclass(frozen=True)
class Boundless(Delivery):
    """A task whose fitness is not finite."""

    def fitness(self, score):
        return float("inf")


@pytest.mark.parametrize(
    ("parts", "task", "told"),
    [
        ({"reward": {"endless": Endless}}, {"reward": "endless"}, "reward Endless: is not finite in every step"),
        ({"task": {"boundless": Boundless}}, {"name": "boundless"}, "task Boundless: fitness is inf; accepted is"),
    ],
)
def test_what_is_not_finite_is_named(parts, task, told):
    with registered(parts), pytest.raises(InputError, match=f"^{told}"):
        driver.evolve([Settings(task=Task(**task), **SMALL)])
