"""Episodes advanced by the native chunk: the arrays that its calls take, in their order (``buffers.h``).

Episodes are of JAX's arrays, inside of compiled programs, or of NumPy's: then the library is called at once, without
XLA, and changes them in place.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.episode import Episode, Parameters, Result
from slcs2_jax.native import library
from slcs2_jax.native.choice import FADINGS, POLICIES
from slcs2_jax.policy import strength
from slcs2_jax.policy.classifier import Classifier, Memory
from slcs2_jax.policy.policy import Figures
from slcs2_jax.swarm.state import initial_state
from slcs2_jax.world.arena import Arena

WORLD = ("sink_x", "sink_y", "estimate_x", "estimate_y", "jammer_x", "jammer_y", "has_jammer", "time_limit", "channels")
STATE = (
    "t", "key", "node_x", "node_y", "power", "known_time", "known_x", "known_y", "heard", "jammer_range", "holding",
    "history", "waiting", "delivered", "contribution", "interference",
)  # fmt: skip
MEMORY = ("usage", "quality", "error", "strength", "trace", "reward", "recent")
PROPAGATION = ("gain", "slope", "floor", "wall")
RADIO = ("noise", "sensitivity", "threshold", "half_power", "network_range")
SWARM = ("packets", "speed", "clearance", "clear", "lidar_range", "distance_threshold", "tolerance", "half_thickness",
         "cost_move", "cost_communicate")  # fmt: skip
LEARNING = ("alpha_grasp", "alpha_q", "alpha_q_final", "beta_q", "trace_decay")
WORD = 32  # bits


@dataclasses.dataclass(frozen=True)
class Sizes:
    """What all episodes of a call have in common; the order is that of ``state.h``.

    batch, agents, rules, words (of a condition), channels; vertical, horizontal: rows for walls; period: steps between
    exchanges of knowledge; round: steps between settlements; depth: BP_max; periods: to compute; policy and fading:
    places in ``POLICIES`` and ``FADINGS``; reflexes: whether rules can be reflexes; noted: whether every step of the
    first episode is written down.
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

    @classmethod
    def of(cls, episode: Episode, parameters: Parameters, periods: int, *, noted: bool = False) -> Sizes:
        """Of a batch of episodes."""
        words, rules, agents, batch = episode.given.mask.shape
        period, depth = parameters.sharing_period, parameters.learning.bp_max
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
            fading=FADINGS.index(type(parameters.physics.radio.fading)),
            reflexes=int(episode.given.reflex is not None),
            noted=int(noted),
        )

    def as_array(self) -> np.ndarray:
        """int32, in order."""
        return np.array(dataclasses.astuple(self), np.int32)


def notes_shapes(sizes: Sizes) -> dict[str, jax.ShapeDtypeStruct]:
    """What is written down of every step, see ``looking.recording``; ``matched`` is a sum over the steps."""
    steps, n = sizes.periods * sizes.period, sizes.agents
    shapes: dict[str, tuple[tuple[int, ...], Any]] = {
        "running": ((steps,), bool),
        "x": ((steps, n), np.float32),
        "y": ((steps, n), np.float32),
        "holding": ((steps, n), bool),
        "waiting": ((steps,), np.int32),
        "delivered": ((steps,), np.int32),
        "heard": ((steps, -(-(n + 2) // WORD), n), np.uint32),
        "jammed": ((steps,), np.int8),
        "action": ((steps, n), np.uint8),
        "rule": ((steps, n), np.int16),
        "sent_to": ((steps, n), np.int8),
        "sent_fate": ((steps, n), np.uint8),
        "served": ((steps, sizes.channels), np.int8),
        "served_fate": ((steps, sizes.channels), np.uint8),
        "matched": ((sizes.rules, n), np.int32),
    }
    return {name: jax.ShapeDtypeStruct(shape, kind) for name, (shape, kind) in shapes.items()}


def given_arrays(episode: Episode, parameters: Parameters) -> list[Any]:
    """What a call reads."""
    arena: Arena = episode.arena
    walls = [getattr(side, name) for side in (arena.walls.vertical, arena.walls.horizontal)
             for name in ("at", "low", "high")]  # fmt: skip
    physics, learning, rules = parameters.physics, parameters.learning, episode.given
    radio = physics.radio
    sections = ((radio.propagation, PROPAGATION), (radio, RADIO), (physics.swarm, SWARM), (learning, LEARNING))
    values = [getattr(section, name) for section, names in sections for name in names]
    (spread,) = jax.tree.leaves(radio.fading) or [np.float32(0)]
    xp = arena.time_limit.__array_namespace__()
    scalars = xp.stack([xp.asarray(value, xp.float32) for value in (spread, *values)])
    reflex = xp.zeros(0, bool) if rules.reflex is None else rules.reflex
    return [*(getattr(arena, name) for name in WORLD), *walls, rules.mask, rules.action, reflex, scalars]


def kept_arrays(episode: Episode) -> list[Any]:
    """What a call changes."""
    memory = episode.memory
    learnt = [getattr(memory, name) for name in MEMORY] if isinstance(memory, Memory) else [memory]
    return [getattr(episode.state, name) for name in STATE] + learnt


def begin(arena: Arena, given: Any, key: jax.Array, parameters: Parameters) -> Episode:
    """``episode.begin``, but that the links of the first step are not drawn yet: ``advance`` does so itself."""
    physics = parameters.physics
    state = initial_state(arena, key, physics.swarm.packets, physics.radio.noise)
    return Episode(arena, given, state, parameters.policy.initial_memory(given, arena.start_x, parameters.learning))


def advance(episode: Episode, parameters: Parameters, periods: int) -> Episode:
    """``episode.advance`` for a batch of episodes whose axis is the last, by the native chunk.

    Episodes that are over when it begins stay as they are.
    """
    return _call("slcs2_advance", episode, parameters, Sizes.of(episode, parameters, periods))[0]


def advance_in_place(episode: Episode, parameters: Parameters, periods: int, threads: int) -> None:
    """``advance`` for NumPy arrays, C-contiguous and each with memory of its own; lane groups are shared by threads."""
    _call_in_place("slcs2_advance", episode, parameters, Sizes.of(episode, parameters, periods), threads)


def watch(episode: Episode, parameters: Parameters, periods: int) -> tuple[Episode, dict[str, jax.Array], jax.Array]:
    """``advance``; of the first episode notes of every step; and in how many steps each of its rules held: [R, n]."""
    sizes = Sizes.of(episode, parameters, periods, noted=True)
    before = episode.state
    episode, notes = _call("slcs2_advance", episode, parameters, sizes)
    matched = notes.pop("matched")
    steps = notes["running"].shape
    notes["jammer_x"], notes["jammer_y"] = (
        jnp.broadcast_to(at[-1:, 0], (*steps, 1)) for at in (before.node_x, before.node_y)
    )
    notes["jammed"] = notes["jammed"][:, None]
    notes["down"] = jnp.zeros(notes["holding"].shape, bool)
    return episode, notes, matched


def result(episode: Episode, parameters: Parameters) -> Result:
    """``episode.result`` for a batch of episodes, by the native code; those of NumPy arrays are used up."""
    policy, state = parameters.policy, episode.state
    figures: Figures | None
    if type(policy) is Classifier:
        sizes = Sizes.of(episode, parameters, 0)
        if isinstance(state.t, np.ndarray):
            _call_in_place("slcs2_finish", episode, parameters, sizes, threads=1)
        else:
            episode, _ = _call("slcs2_finish", episode, parameters, sizes)
        end = episode.memory
        figures = Figures(quality=end.quality, strength=end.strength, error=end.error, usage=end.usage)
    else:
        figures = policy.finish(episode.memory, state.t, parameters.learning)
    return Result(
        steps=state.t,
        delivered=state.delivered,
        contribution=state.contribution,
        figures=figures,
        measures={},
    )


def _call(name: str, episode: Episode, parameters: Parameters, sizes: Sizes) -> tuple[Episode, dict[str, jax.Array]]:
    given, kept = given_arrays(episode, parameters), kept_arrays(episode)
    notes = notes_shapes(sizes) if sizes.noted else {}
    shapes = [*(jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in kept), *notes.values()]
    aliases = {len(given) + k: k for k in range(len(kept))}
    found = jax.ffi.ffi_call(name, shapes, input_output_aliases=aliases)(*given, *kept, sizes=sizes.as_array())
    fields: dict[str, Any] = dict(zip(STATE, found, strict=False))
    state = dataclasses.replace(episode.state, **fields)
    learnt = found[len(STATE) : len(kept)]
    one = isinstance(episode.memory, Memory)
    memory = dataclasses.replace(episode.memory, **dict(zip(MEMORY, learnt, strict=True))) if one else learnt[0]
    noted = dict(zip(notes, found[len(kept) :], strict=True))
    return dataclasses.replace(episode, state=state, memory=memory), noted


def _call_in_place(name: str, episode: Episode, parameters: Parameters, sizes: Sizes, threads: int) -> None:
    given, kept = given_arrays(episode, parameters), kept_arrays(episode)
    nothing = [None] * (len(STATE) + len(MEMORY) - len(kept) + len(notes_shapes(sizes)))
    library.call(name, sizes.as_array(), [*given, *kept, *nothing], threads)
