"""A world in which little is to be learnt, and settings with which that goes quickly."""

from dataclasses import replace

from slcs2_jax.config import Compute, Settings, Swarm, World
from slcs2_jax.learning.evolution_strategy import Strategy
from slcs2_jax.learning.ippo import Ippo
from slcs2_jax.learning.network_settings import NetworkSettings

SETTINGS = Settings(
    world=World(distance=120.0, time_limit=150), swarm=Swarm(agents=3, packets=4), compute=Compute(devices=1)
)
TRAINED = [(SETTINGS, range(4_000_000, 4_000_008))]
FRESH = range(4_000_050, 4_000_060)


def ippo(*, recurrent: int = 0, **changes) -> Ippo:
    network = NetworkSettings(hidden=(16,), recurrent=recurrent)
    small = Ippo(
        network=network,
        episodes=16,
        chunk=50,
        unroll=10,
        minibatches=4,
        learning_rate=3e-3,
        discount=0.99,
        snapshot=4000,
    )
    return replace(small, **changes)


def strategy(**changes) -> Strategy:
    return replace(Strategy(network=NetworkSettings(hidden=(8,)), population=16, worlds=1), **changes)
