"""The arrays that native calls take, in their order (``buffers.h``); empty where a call does without a part."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.policy import strength
from slcs2_jax.policy.classifier import Classifier, Memory
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.swarm.state import State
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.emitters import Emitters
from slcs2_jax.world.fading import LogNormal, Nakagami, NoFading, Rayleigh, Rician

POLICIES = (Classifier, FirstMatch)
FADINGS = (NoFading, LogNormal, Rayleigh, Rician, Nakagami)
EMISSIONS = ("reactive", "constant", "random", "sweeping")
MOTIONS = ("fixed", "patrol", "pursue")

WORLD = ("sink_x", "sink_y", "estimate_x", "estimate_y", "jammer_x", "jammer_y", "has_jammer", "time_limit", "channels")
STATE = (
    "t", "key", "node_x", "node_y", "power", "known_time", "known_x", "known_y", "heard", "jammer_range", "holding",
    "history", "waiting", "delivered", "contribution", "interference",
)  # fmt: skip
JAMMERS = ("x", "y", "power", "seen_time", "seen_x", "seen_y", "seen_range")
FAILING = ("down", "lost")
MEMORY = ("usage", "quality", "error", "strength", "trace", "members", "reward", "recent")
PROPAGATION = ("gain", "slope", "floor", "wall")
RADIO = ("noise", "sensitivity", "threshold", "half_power", "network_range")
SWARM = ("packets", "speed", "clearance", "clear", "lidar_range", "distance_threshold", "tolerance", "half_thickness",
         "cost_move", "cost_communicate")  # fmt: skip
LEARNING = ("alpha_grasp", "alpha_q", "alpha_q_final", "beta_q", "trace_decay")
FAILURES = ("rate", "recovery", "count")
EMITTERS = ("exists", "route_x", "route_y", "emission", "motion", "level", "speed", "duty", "dwell")
WORD = 32  # bits
MOST_KEPT = len(STATE) + len(JAMMERS) + len(FAILING) + len(MEMORY)  # arrays that a call changes


@dataclasses.dataclass(frozen=True)
class Sizes:
    """What all episodes of a call have in common; the order is that of ``state.h``.

    batch, agents, rules, words (of a condition), channels; vertical, horizontal: rows for walls; period: steps between
    exchanges of knowledge; round: steps between settlements; depth: BP_max; periods: to compute; policy and fading:
    places in ``POLICIES`` and ``FADINGS``; reflexes: whether rules can be reflexes; noted: whether every step of the
    first episode is written down; vocabulary: channels that actions can name; jammers: J where they are more than the
    paper's one, else 0; points: of a jammer's route; failing: whether agents can fail; keeps: whether the packet of one
    that fails stays with it; failures: how many times there are at which agents fail.
    """

    batch: int
    agents: int
    rules: int
    words: int
    channels: int
    vertical: int
    horizontal: int
    period: int
    round: int
    depth: int
    periods: int
    policy: int
    fading: int
    reflexes: int
    noted: int
    vocabulary: int
    jammers: int
    points: int
    failing: int
    keeps: int
    failures: int

    @classmethod
    def of(cls, episode: Episode, parameters: Parameters, periods: int, *, noted: bool = False) -> Sizes:
        """Of a batch of episodes."""
        words, rules, agents, batch = episode.given.mask.shape
        period, depth = parameters.sharing_period, parameters.learning.bp_max
        physics, emitters = parameters.physics, episode.arena.emitters
        failures = physics.swarm.failures
        points, jammers = (0, 0) if emitters is None else emitters.route_x.shape[:2]
        return cls(
            batch=batch,
            agents=agents,
            rules=rules,
            words=words,
            channels=episode.arena.channels.shape[0],
            vertical=episode.arena.walls.vertical.at.shape[0],
            horizontal=episode.arena.walls.horizontal.at.shape[0],
            period=period,
            round=strength.round_length(period, depth),
            depth=depth,
            periods=periods,
            policy=POLICIES.index(type(parameters.policy)),
            fading=FADINGS.index(type(physics.radio.fading)),
            reflexes=int(episode.given.reflex is not None),
            noted=int(noted),
            vocabulary=len(physics.language.vocabulary.channels),
            jammers=jammers,
            points=points,
            failing=int(failures is not None),
            keeps=int(failures is not None and failures.keeps_packet),
            failures=0 if failures is None else failures.times.shape[0],
        )

    def as_array(self) -> np.ndarray:
        """int32, in order."""
        return np.array(dataclasses.astuple(self), np.int32)


def notes_shapes(sizes: Sizes) -> dict[str, jax.ShapeDtypeStruct]:
    """What is written down of every step, see ``looking.recording``; ``matched`` is a sum over the steps."""
    steps, n, jammers = sizes.periods * sizes.period, sizes.agents, max(1, sizes.jammers)
    shapes: dict[str, tuple[tuple[int, ...], Any]] = {
        "running": ((steps,), bool),
        "x": ((steps, n), np.float32),
        "y": ((steps, n), np.float32),
        "holding": ((steps, n), bool),
        "waiting": ((steps,), np.int32),
        "delivered": ((steps,), np.int32),
        "heard": ((steps, -(-(n + 2) // WORD), n), np.uint32),
        "jammed": ((steps, jammers), np.int8),
        "action": ((steps, n), np.uint8),
        "rule": ((steps, n), np.int16),
        "sent_to": ((steps, n), np.int8),
        "sent_fate": ((steps, n), np.uint8),
        "served": ((steps, sizes.channels), np.int8),
        "served_fate": ((steps, sizes.channels), np.uint8),
        "jammer_x": ((steps, jammers), np.float32),
        "jammer_y": ((steps, jammers), np.float32),
        "down": ((steps, n), bool),
        "matched": ((sizes.rules, n), np.int32),
    }
    return {name: jax.ShapeDtypeStruct(shape, kind) for name, (shape, kind) in shapes.items()}


def given_arrays(episode: Episode, parameters: Parameters) -> list[Any]:
    """What a call reads. Leaves of the parameters are those of all episodes, or [..., batch], each episode's own."""
    arena: Arena = episode.arena
    xp = arena.time_limit.__array_namespace__()  # NumPy or JAX
    walls = [getattr(side, name) for side in (arena.walls.vertical, arena.walls.horizontal)
             for name in ("at", "low", "high")]  # fmt: skip
    rules, failures = episode.given, parameters.physics.swarm.failures
    return [
        *(getattr(arena, name) for name in WORLD),
        *walls,
        rules.mask,
        rules.action,
        xp.zeros(0, bool) if rules.reflex is None else rules.reflex,
        *_emitters(arena.emitters, xp),
        xp.zeros(0, xp.int32) if failures is None else _of_each(failures.times, 1, arena, xp),
        _values(parameters, arena, xp),
    ]


def _of_each(value: Any, axes: int, arena: Arena, xp: Any) -> Any:
    """A parameter of so many axes for each episode: [..., batch], if it is not so already."""
    if value.ndim > axes:
        return value
    return xp.broadcast_to(value[..., None], (*value.shape, arena.time_limit.shape[0]))


def _values(parameters: Parameters, arena: Arena, xp: Any) -> Any:
    physics = parameters.physics
    radio, failures = physics.radio, physics.swarm.failures
    sections = (
        (radio.propagation, PROPAGATION),
        (radio, RADIO),
        (physics.swarm, SWARM),
        (parameters.learning, LEARNING),
    )
    values = [getattr(section, name) for section, names in sections for name in names]
    fails = [np.float32(0) if failures is None else getattr(failures, name) for name in FAILURES]
    (fading,) = jax.tree.leaves(radio.fading) or [np.float32(0)]
    every = (xp.asarray(value, xp.float32) for value in (fading, *values, *fails))
    return xp.stack([_of_each(value, 0, arena, xp) for value in every])


def _emitters(emitters: Emitters | None, xp: Any) -> list[Any]:
    if emitters is None:
        return [xp.zeros(0, xp.float32)] * len(EMITTERS)
    arrays = {name: getattr(emitters, name) for name in EMITTERS}
    for name, said, known in (("emission", emitters.emissions, EMISSIONS), ("motion", emitters.motions, MOTIONS)):
        arrays[name] = xp.asarray([known.index(one) for one in said], xp.int32)[arrays[name]]
    return list(arrays.values())


def kept_arrays(episode: Episode) -> list[Any]:
    """What a call changes."""
    state, memory = episode.state, episode.memory
    xp = state.t.__array_namespace__()
    nothing = xp.zeros((0, *state.t.shape), xp.float32)
    jammers = [nothing if state.jammers is None else getattr(state.jammers, name) for name in JAMMERS]
    failing = [nothing if state.down is None else getattr(state, name) for name in FAILING]
    learnt = [getattr(memory, name) for name in MEMORY] if isinstance(memory, Memory) else [memory]
    return [*(getattr(state, name) for name in STATE), *jammers, *failing, *learnt]


def with_kept(episode: Episode, arrays: Sequence[Any]) -> Episode:
    """The episode with what a call made of `kept_arrays`."""
    left = iter(arrays)
    values, jammers, failing = ({name: next(left) for name in names} for names in (STATE, JAMMERS, FAILING))
    state: State = dataclasses.replace(episode.state, **values)
    if state.jammers is not None:
        state = dataclasses.replace(state, jammers=dataclasses.replace(state.jammers, **jammers))
    if state.down is not None:
        state = dataclasses.replace(state, **failing)
    if isinstance(episode.memory, Memory):
        memory = dataclasses.replace(episode.memory, **dict(zip(MEMORY, left, strict=True)))
    else:
        (memory,) = left
    return dataclasses.replace(episode, state=state, memory=memory)
