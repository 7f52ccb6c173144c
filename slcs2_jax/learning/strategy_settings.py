"""Settings of the evolution strategy."""

from __future__ import annotations

from dataclasses import dataclass, field

from slcs2_jax.config.errors import refuse
from slcs2_jax.config.field import LEAST, Section, setting
from slcs2_jax.learning.network_settings import NetworkSettings


@dataclass(frozen=True)
class Strategy(Section):
    """How the evolution strategy learns."""

    SECTION = "strategy"

    network: NetworkSettings = field(default_factory=lambda: NetworkSettings(hidden=(32,)))
    population: int = setting(
        32, "networks of a generation: pairs of opposite ones", unit="networks", status="run", low=2, high=10_000
    )
    worlds: int = setting(
        1, "worlds that each of them is deployed in, the same for all of a generation", status="run", low=1, high=10_000
    )
    deviation: float = setting(
        0.1, "sigma, standard deviation of the noise on each weight", status="run", low=LEAST, high=100
    )
    learning_rate: float = setting(0.05, "Adam's", status="run", low=0, high=10)
    decay: float = setting(0.005, "of the weights, per step and learning rate", status="run", low=0, high=1)
    snapshot: int = setting(
        1_000_000, "keep the policy whenever so many env-steps more are done", unit="env-steps", status="run",
        low=1, high=10**12,
    )  # fmt: skip

    def cross_check(self) -> None:
        if self.population % 2:
            raise refuse("strategy.population", self.population, "an even number")
