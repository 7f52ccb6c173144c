"""The state of an episode and the swarm's parameters.

Axes grow to the left: instance [...], agent [n, ...], link [other, self, ...]. Trailing axes are the batch, if any; no
function names it, and every one works on a single instance as on thousands.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.settings import Settings
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import SLACK

UNKNOWN = np.int32(-1)  # time of knowledge never had
WORD = 32  # agents per word of a packet's history
OTHER_NODES = 3  # source, sink and jammer, behind the agents


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class SwarmParameters:
    """Spec section 4, every leaf a scalar: m, m per step, counts and costs.

    ``clear`` is the squared distance, m2, that keeps the clearance: a little less than its square, see ``SLACK``.
    """

    packets: jax.Array
    speed: jax.Array
    clearance: jax.Array
    clear: jax.Array
    lidar_range: jax.Array
    distance_threshold: jax.Array
    tolerance: jax.Array
    half_thickness: jax.Array
    cost_move: jax.Array
    cost_communicate: jax.Array

    @classmethod
    def of(cls, settings: Settings) -> SwarmParameters:
        """Take the values from the settings."""
        swarm, learning = settings.swarm, settings.learning
        return cls(
            packets=jnp.int32(swarm.packets),
            speed=jnp.float32(swarm.speed),
            clearance=jnp.float32(swarm.clearance),
            clear=jnp.float32(max(swarm.clearance - SLACK, 0) ** 2),
            lidar_range=jnp.float32(swarm.lidar_range),
            distance_threshold=jnp.float32(swarm.distance_threshold),
            tolerance=jnp.float32(swarm.tolerance),
            half_thickness=jnp.float32(settings.world.wall_thickness / 2),
            cost_move=jnp.float32(learning.cost_move),
            cost_communicate=jnp.float32(learning.cost_communicate),
        )


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class State:
    """What changes from step to step.

    Attributes:
        t: int32 [...], time-steps done.
        key: uint32 [2, ...], the episode's key.
        node_x, node_y: float32 [n + 3, ...], m, agents, source, sink and jammer.
        power: float32 [rows, n + 3, ...], mW, the links of the step to come, folded (see ``links``).
        known_time: int32 [n other, n self, ...], when self's news of other is from; ``UNKNOWN`` for none.
        known_x, known_y: float32 [n other, n self, ...], m, where other was then.
        heard: bool [n + 2, n, ...], whose beacons self decoded in the last step: agents, source, sink.
        jammer_range: float32 [n, ...], m, greatest distance at which the jammer was heard, xi; 0 if unknown.
        holding: bool [n, ...], a packet in the buffer.
        history: uint32 [words, n, ...], bits of the agents that held the packet in self's buffer.
        waiting, delivered: int32 [...], packets at the source and at the sink.
        contribution: int32 [n, ...], delivered packets that self held.
        interference: float32 [C, n, ...], mW, NI: noise and interference measured over the last step.
    """

    t: jax.Array
    key: jax.Array
    node_x: jax.Array
    node_y: jax.Array
    power: jax.Array
    known_time: jax.Array
    known_x: jax.Array
    known_y: jax.Array
    heard: jax.Array
    jammer_range: jax.Array
    holding: jax.Array
    history: jax.Array
    waiting: jax.Array
    delivered: jax.Array
    contribution: jax.Array
    interference: jax.Array

    @property
    def x(self) -> jax.Array:
        """The agents' places along the line from source to sink: float32 [n, ...], m."""
        return self.node_x[:-OTHER_NODES]

    @property
    def y(self) -> jax.Array:
        """The agents' places across that line: float32 [n, ...], m."""
        return self.node_y[:-OTHER_NODES]


def initial_state(arena: Arena, key: jax.Array, packets: jax.Array, noise: jax.Array) -> State:
    """The swarm as deployed: at its start positions, knowing nothing, all packets at the source, no links drawn.

    Args:
        arena: scenarios [...].
        key: uint32 [2, ...].
        packets: int32 scalar.
        noise: float32 scalar, thermal noise in mW.
    """
    n, *batch = arena.start_x.shape
    pairs = jnp.zeros((n, n, *batch), jnp.float32)
    origin = jnp.zeros_like(arena.sink_x)
    nodes = n + OTHER_NODES
    return State(
        t=jnp.zeros(batch, jnp.int32),
        key=key,
        node_x=jnp.concatenate([arena.start_x, jnp.stack([origin, arena.sink_x, arena.jammer_x])]),
        node_y=jnp.concatenate([arena.start_y, jnp.stack([origin, arena.sink_y, arena.jammer_y])]),
        power=jnp.zeros((-(-nodes // 2), nodes, *batch), jnp.float32),
        known_time=jnp.full((n, n, *batch), UNKNOWN),
        known_x=pairs,
        known_y=pairs,
        heard=jnp.zeros((n + 2, n, *batch), bool),
        jammer_range=jnp.zeros((n, *batch), jnp.float32),
        holding=jnp.zeros((n, *batch), bool),
        history=jnp.zeros((-(-n // WORD), n, *batch), jnp.uint32),
        waiting=jnp.full(batch, packets, jnp.int32),
        delivered=jnp.zeros(batch, jnp.int32),
        contribution=jnp.zeros((n, *batch), jnp.int32),
        interference=jnp.full((arena.channels.shape[0], n, *batch), noise, jnp.float32),
    )


def lift(constant: np.ndarray, like: jax.Array) -> np.ndarray:
    """Append as many axes of size one to a constant as ``like`` has, so that it broadcasts over the batch."""
    return constant.reshape(constant.shape + (1,) * like.ndim)
