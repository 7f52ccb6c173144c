"""The state of an episode and the swarm's parameters.

Axes grow to the left: instance [...], agent [n, ...], link [other, self, ...]. Trailing axes are the batch, if any; no
function names it, and every one works on a single instance as on thousands.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm.failure import FailureParameters
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import SLACK

UNKNOWN = np.int32(-1)  # time of knowledge never had
WORD = 32  # agents per word of a packet's history
OTHER_NODES = 3  # source, sink and jammer, behind the agents


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class SwarmParameters:
    """Model section 4, every leaf a scalar: m, m per step, counts and costs.

    ``clear`` is the squared distance, m2, that keeps the clearance: a little less than its square, see ``SLACK``.
    ``failures`` is None where nobody ever fails.
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
    failures: FailureParameters | None = None

    @classmethod
    def of(cls, settings: Any) -> SwarmParameters:
        """Take the values from the settings, or anything with their attributes, of which numbers may be traced."""
        swarm, learning = settings.swarm, settings.learning
        beyond_slack = swarm.clearance - SLACK
        return cls(
            packets=jnp.int32(swarm.packets),
            speed=jnp.float32(swarm.speed),
            clearance=jnp.float32(swarm.clearance),
            clear=jnp.float32(((beyond_slack + abs(beyond_slack)) / 2) ** 2),  # its square, or 0 if it is less
            lidar_range=jnp.float32(swarm.lidar_range),
            distance_threshold=jnp.float32(swarm.distance_threshold),
            tolerance=jnp.float32(swarm.tolerance),
            half_thickness=jnp.float32(settings.world.wall_thickness / 2),
            cost_move=jnp.float32(learning.cost_move),
            cost_communicate=jnp.float32(learning.cost_communicate),
            failures=FailureParameters.of(swarm),
        )


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class JammerState:
    """The J jammers of a world where they are more than the paper's one.

    Attributes:
        x, y: float32 [J - 1, ...], m, where the second and further ones are; the first is a node.
        power: float32 [J - 1, n + 2, ...], mW, their links of the step to come.
        seen_time: int32 [J, n, ...], when self's news of a jammer is from; ``UNKNOWN`` for none.
        seen_x, seen_y: float32 [J, n, ...], m, where it was then.
        seen_range: float32 [J, n, ...], m, greatest distance at which it was heard; 0 if it never was.
    """

    x: jax.Array
    y: jax.Array
    power: jax.Array
    seen_time: jax.Array
    seen_x: jax.Array
    seen_y: jax.Array
    seen_range: jax.Array


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
        jammer_range: float32 [n, ...], m, greatest distance at which the jammer was heard, xi; 0 if unknown. Of
            several, that of the nearest.
        holding: bool [n, ...], a packet in the buffer.
        history: uint32 [words, n, ...], bits of the agents that held the packet in self's buffer.
        waiting, delivered: int32 [...], packets at the source and at the sink.
        contribution: int32 [n, ...], delivered packets that self held.
        interference: float32 [C, n, ...], mW, NI: noise and interference measured over the last step.
        jammers: all jammers; None where there is none but one that stays and answers.
        down: bool [n, ...], who does not work in the step to come; None where nobody ever fails.
        lost: int32 [...], packets that agents have lost by failing; None where nobody ever fails.
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
    jammers: JammerState | None = None
    down: jax.Array | None = None
    lost: jax.Array | None = None

    @property
    def settled(self) -> jax.Array:
        """Packets that are no longer under way, delivered or lost: int32 [...]."""
        return self.delivered if self.lost is None else self.delivered + self.lost

    @property
    def x(self) -> jax.Array:
        """The agents' places along the line from source to sink: float32 [n, ...], m."""
        return self.node_x[:-OTHER_NODES]

    @property
    def y(self) -> jax.Array:
        """The agents' places across that line: float32 [n, ...], m."""
        return self.node_y[:-OTHER_NODES]


def initial_state(
    arena: Arena, key: jax.Array, packets: jax.Array, noise: jax.Array, *, failing: bool = False
) -> State:
    """The swarm as deployed: at its start positions, knowing nothing, all packets at the source, no links drawn.

    Args:
        arena: scenarios [...].
        key: uint32 [2, ...].
        packets: int32 scalar.
        noise: float32 scalar, thermal noise in mW.
        failing: whether agents can fail.

    Returns:
        Arrays of the kind that the arena's are, NumPy's or JAX's.
    """
    xp = arena.start_x.__array_namespace__()
    n, *batch = arena.start_x.shape
    pairs = xp.zeros((n, n, *batch), xp.float32)
    origin = xp.zeros_like(arena.sink_x)
    nodes = n + OTHER_NODES
    return State(
        t=xp.zeros(batch, xp.int32),
        key=key,
        node_x=xp.concatenate([arena.start_x, xp.stack([origin, arena.sink_x, arena.jammer_x])]),
        node_y=xp.concatenate([arena.start_y, xp.stack([origin, arena.sink_y, arena.jammer_y])]),
        power=xp.zeros((-(-nodes // 2), nodes, *batch), xp.float32),
        known_time=xp.full((n, n, *batch), UNKNOWN, xp.int32),
        known_x=pairs,
        known_y=pairs,
        heard=xp.zeros((n + 2, n, *batch), bool),
        jammer_range=xp.zeros((n, *batch), xp.float32),
        holding=xp.zeros((n, *batch), bool),
        history=xp.zeros((-(-n // WORD), n, *batch), xp.uint32),
        waiting=xp.full(batch, packets, xp.int32),
        delivered=xp.zeros(batch, xp.int32),
        contribution=xp.zeros((n, *batch), xp.int32),
        interference=xp.full((arena.channels.shape[0], n, *batch), noise, xp.float32),
        jammers=_initial_jammers(arena),
        down=xp.zeros((n, *batch), bool) if failing else None,
        lost=xp.zeros(batch, xp.int32) if failing else None,
    )


def _initial_jammers(arena: Arena) -> JammerState | None:
    if arena.emitters is None:
        return None
    xp = arena.start_x.__array_namespace__()
    n, *batch = arena.start_x.shape
    x, y = arena.emitters.route_x[0], arena.emitters.route_y[0]
    unseen = xp.zeros((x.shape[0], n, *batch), xp.float32)
    return JammerState(
        x=x[1:],
        y=y[1:],
        power=xp.zeros((x.shape[0] - 1, n + 2, *batch), xp.float32),
        seen_time=xp.full(unseen.shape, UNKNOWN, xp.int32),
        seen_x=unseen,
        seen_y=unseen,
        seen_range=unseen,
    )


def lift(constant: np.ndarray, like: jax.Array) -> np.ndarray:
    """Append as many axes of size one to a constant as ``like`` has, so that it broadcasts over the batch."""
    return constant.reshape(constant.shape + (1,) * like.ndim)
