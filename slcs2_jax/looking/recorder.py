"""Computing one episode and keeping all of it: by the native chunk if it knows the episode, else by the JAX step."""

from __future__ import annotations

import functools
from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from slcs2_jax import episode as episodes
from slcs2_jax.config import Settings
from slcs2_jax.episode import Episode, Moment, Parameters, Result
from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.looking.recording import NOBODY, WORD, Recording
from slcs2_jax.native import advance as native
from slcs2_jax.native import choice
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.policy.policy import Figures
from slcs2_jax.rollout import LANES
from slcs2_jax.running.memory import check_fits
from slcs2_jax.swarm import jamming
from slcs2_jax.swarm.fate import fates
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.state import State
from slcs2_jax.swarm.task import Score, task_of
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.scenario import Scenario, check_scenario

CHUNK = 100  # sharing periods that are computed at a time


def record(
    settings: Settings,
    scenario: Scenario,
    deployed: BoundPolicy,
    key: tuple[np.uint32, np.uint32],
    *,
    steps: int | None = None,
    after_chunk: Callable[[int], None] = lambda steps: None,
) -> Recording:
    """Compute one episode and keep all of it.

    The episode is the one that a search or an evaluation with this key had. The native chunk, if it computes, hands out
    what it does itself; XLA's arithmetic is laid out as in a rollout on one CPU device, and on other devices or
    versions a last bit may differ and lead elsewhere.

    Args:
        settings: radio, swarm and learning.
        scenario: where.
        deployed: what decides.
        key: the episode's key.
        steps: stop after so many, or the first whole chunk that has them; None: at the end of the episode.
        after_chunk: told now and then how many steps were computed.

    Raises:
        InputError: the scenario is none for these settings, or the recording would not fit into memory.
    """
    check_scenario(scenario, settings)
    check_fits("world.time_limit", scenario.time_limit, _step_bytes(settings.swarm.agents), "a recording")
    parameters = Parameters.of(settings, deployed.policy, deployed.language)
    given = _given(scenario, deployed, key)
    by_native, _ = choice.choose(settings.compute.native, jax.default_backend(), parameters, *given[:2])
    if by_native:
        given = jax.tree.map(lambda leaf: leaf[..., :1], given)
    most = scenario.time_limit if steps is None else min(steps, scenario.time_limit)
    begin, watch, result = _programs(min(CHUNK, -(-most // settings.swarm.sharing_period)), by_native)
    episode = begin(*given, parameters)
    matched: Any = 0
    parts: list[dict[str, NDArray[Any]]] = []
    running = True
    computed = 0
    while running and computed < most:
        episode, notes, held = watch(episode, parameters)
        part = jax.tree.map(np.asarray, notes)
        matched = matched + np.asarray(held).T
        parts.append(part)
        running = bool(part["running"][-1])
        computed += int(part["running"].sum())
        after_chunk(computed)
    end = jax.tree.map(lambda leaf: np.asarray(leaf)[..., 0], (episode.state, result(episode, parameters)))
    return _recording(settings, scenario, deployed, parts, matched, *end, ended=not running)


def _step_bytes(agents: int) -> int:
    """Of a step as it is recorded, twice: its parts are joined in the end."""
    return 2 * (64 + 20 * agents + 4 * (agents + 2) * -(-(agents + 2) // WORD))


def _given(scenario: Scenario, deployed: BoundPolicy, key: tuple[np.uint32, np.uint32]) -> Any:
    """What an episode starts from: the same one in every lane, since a vector unit takes no fewer."""

    def lanes(array: NDArray[Any]) -> NDArray[Any]:
        return np.repeat(array[..., None], LANES, axis=-1)

    capacity, channels = wall_capacity([scenario]), deployed.channels
    arena = stack([scenario] * LANES, [channels] * LANES, capacity=capacity, width=max(channels) + 1)
    arrays = deployed.policy.arrays(deployed.given, deployed.language)
    return arena, jax.tree.map(lanes, arrays), lanes(np.array(key, np.uint32))


@functools.cache
def _programs(chunk: int, by_native: bool) -> tuple[Any, Any, Any]:
    """Begin, watch a chunk of so many sharing periods, and result, compiled for the default backend.

    `watch` returns the episode, the notes of every step, and in how many steps each rule held: int32 [R, n].
    """
    on_cpu = jax.default_backend() == "cpu"
    program = partial(jax.jit, compiler_options={"xla_cpu_prefer_vector_width": 512} if on_cpu else None)

    def watch_natively(episode: Episode, parameters: Parameters) -> tuple[Episode, Any, jax.Array]:
        return native.watch(episode, parameters, chunk)

    def watch(episode: Episode, parameters: Parameters) -> tuple[Episode, Any, jax.Array]:
        episode, notes = episodes.watch(episode, parameters, chunk, partial(_note, parameters))
        held = jnp.sum(notes.pop("match"), axis=(0, 1, 2), dtype=jnp.int32)
        return episode, jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[3:]), notes), held

    if by_native:
        return program(native.begin), program(watch_natively), program(native.result)
    return program(episodes.begin), program(watch), program(episodes.result)


def _note(parameters: Parameters, before: Episode, after: Episode, moment: Moment) -> dict[str, jax.Array]:
    """What is kept of a step, of the first lane alone; names and meaning as in `Recording` where it has them."""
    state, seen, view, air = before.state, moment.seen, moment.seen.view, moment.outcome.air
    n = state.x.shape[0]
    to_agents, to_anybody = air.wanted[:, n, :n], air.wanted[:, :n]
    fate = fates(air, view.links, parameters.physics.radio)
    receiver = np.arange(n + 2).reshape(-1, 1)
    policy = parameters.policy
    chosen = policy.chosen(after.memory, before.given, seen, episodes.clock(before), parameters.learning)
    notes = {
        "running": view.running,
        "x": state.x,
        "y": state.y,
        "holding": state.holding,
        "waiting": state.waiting,
        "delivered": state.delivered,
        "heard": _packed(view.links.heard),
        **_jammers(state, view.links),
        "down": jnp.zeros(state.x.shape, bool) if state.down is None else state.down,
        "action": jnp.where(view.able, moment.action, np.int32(NO_ACTION)).astype(jnp.uint8),
        "rule": chosen.astype(jnp.int16),
        "sent_to": jnp.max(jnp.where(to_anybody, receiver, NOBODY), axis=(0, 2)).astype(jnp.int8),
        "sent_fate": jnp.max(fate[:, :n], axis=(0, 2)),
        "served": jnp.max(jnp.where(to_agents, receiver[:n], NOBODY), axis=1).astype(jnp.int8),
        "served_fate": jnp.max(fate[:, n], axis=1),
        "match": policy.matched(before.given, seen),
    }
    return jax.tree.map(lambda leaf: leaf[..., 0], notes)


def _jammers(state: State, links: Links) -> dict[str, jax.Array]:
    """Where the jammers are, and on which channel each emits."""
    if links.jammers is None:
        emits = _first(jnp.any(links.jamming > 0, axis=1))[None]
        return {"jammer_x": state.node_x[-1:], "jammer_y": state.node_y[-1:], "jammed": emits}
    x, y = jamming.places(state)
    return {"jammer_x": x, "jammer_y": y, "jammed": links.jammers.channel.astype(jnp.int8)}


def _first(flags: jax.Array) -> jax.Array:
    """The first that is true: [C, ...] -> int8 [...]; -1 if none is."""
    found = jnp.argmax(flags, axis=0).astype(jnp.int8)
    return jnp.where(jnp.any(flags, axis=0), found, jnp.int8(NOBODY))


def _packed(flags: jax.Array) -> jax.Array:
    """Bits of the first axis in words of 32: bool [m, ...] -> uint32 [words, ...]."""
    words = []
    for start in range(0, flags.shape[0], WORD):
        some = flags[start : start + WORD].astype(jnp.uint32)
        shift = np.arange(some.shape[0], dtype=np.uint32).reshape(-1, *(1,) * (flags.ndim - 1))
        words.append(jnp.sum(some << shift, axis=0, dtype=jnp.uint32))
    return jnp.stack(words)


def _last(state: State) -> dict[str, NDArray[Any]]:
    """What there is of the last moment."""
    values = {name: getattr(state, name) for name in ("x", "y", "holding", "waiting", "delivered", "down")}
    if state.down is None:
        values["down"] = np.zeros(state.x.shape, bool)
    x, y = (state.node_x[-1:], state.node_y[-1:]) if state.jammers is None else jamming.places(state)
    return {**values, "jammer_x": x, "jammer_y": y}


def _recording(
    settings: Settings,
    scenario: Scenario,
    deployed: BoundPolicy,
    parts: list[dict[str, NDArray[Any]]],
    matched: NDArray[np.int32],
    state: State,
    result: Result,
    *,
    ended: bool,
) -> Recording:
    steps, nothing = int(result.steps), np.zeros(matched.shape, np.float32)
    noted = {name: np.concatenate([part[name] for part in parts])[:steps] for name in parts[0] if name != "running"}
    for name, last in _last(state).items():
        noted[name] = np.concatenate([noted[name], np.asarray(last)[None]])
    for name in ("jammer_x", "jammer_y", "jammed"):  # without the place that is kept for one where there is none
        noted[name] = noted[name][:, : len(scenario.jammers)]
    for name in ("served", "served_fate"):
        noted[name] = noted[name][:, list(deployed.channels)]
    score = Score(
        delivered=int(result.delivered),
        packets=settings.swarm.packets,
        steps=steps,
        time_limit=scenario.time_limit,
        measures=result.measures,
    )
    figures = result.figures or Figures(nothing.T, nothing.T, nothing.T, nothing.T.astype(np.int32))
    return Recording(
        settings=settings,
        scenario=scenario,
        vocabulary=deployed.language.vocabulary,
        rules=deployed.given if isinstance(deployed.given, RuleSets) else None,
        channels=deployed.channels,
        ended=ended,
        fitness=task_of(settings).fitness(score),
        matched=matched,
        contribution=np.asarray(result.contribution),
        **noted,
        **{name: np.asarray(value).T for name, value in vars(figures).items()},
    )
