"""One episode in full, to look at: where everybody was, who sent to whom with what success, which rules acted.

T steps, n agents, R rules, C channels in use. Nodes: agents 0..n-1, source n, sink n + 1.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from slcs2_jax import episode as episodes
from slcs2_jax.config import Settings
from slcs2_jax.episode import Episode, Moment, Parameters, Result
from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.vocabulary import NO_ACTION, Vocabulary
from slcs2_jax.native import advance as native
from slcs2_jax.native import choice
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.policy.policy import Figures
from slcs2_jax.rollout import LANES
from slcs2_jax.running.memory import check_fits
from slcs2_jax.swarm import jamming
from slcs2_jax.swarm.fate import Fate, fates
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.state import State
from slcs2_jax.swarm.task import Score, task_of
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.scenario import Scenario, check_scenario

if TYPE_CHECKING:
    import xarray

CHUNK = 100  # sharing periods that are computed at a time
NOBODY = -1
WORD = 32


class Transmission(NamedTuple):
    """One attempt to hand over a packet; nodes, index of the channel, index of the power, what became of it."""

    sender: int
    receiver: int
    channel: int
    power: int
    fate: Fate


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Recording:
    """An episode, step by step. Step t leads from moment t to moment t + 1; there are T steps and T + 1 moments.

    Attributes:
        settings, scenario: where.
        vocabulary: what the numbers of actions mean.
        rules: what was deployed; None for a policy without rules.
        channels: indices of the channels in use, in the order of the columns of `served`.
        ended: whether it goes to the end of the episode; if not, what else is said is as it was when it was cut.
        fitness: share delivered less share of time used (model section 7).
        x, y: float32 [T + 1, n], m, the agents' places; the source is the origin.
        holding: bool [T + 1, n], who holds a packet.
        waiting, delivered: int32 [T + 1], packets at the source and at the sink.
        heard: uint32 [T, W, n], bit j % 32 of word j // 32 tells whether the agent heard node j; see `neighbours`.
        down: bool [T + 1, n], who had failed and did not work in the step from the moment on.
        jammer_x, jammer_y: float32 [T + 1, J], m, the jammers' places.
        jammed: int8 [T, J], index of the channel that each jammer emitted on; -1 for none.
        action: uint8 [T, n], numbers of the vocabulary; `NO_ACTION` for none.
        rule: int16 [T, n], the rule that was drawn (or, of a behaviour made by hand, the first that held); -1 for none.
        sent_to: int8 [T, n], the node that the agent sent its packet to; -1 if it sent nothing.
        sent_fate: uint8 [T, n], of `Fate`.
        served: int8 [T, C], the agent that the source sent a packet to on each channel; -1 for none.
        served_fate: uint8 [T, C], of `Fate`.
        matched: int32 [n, R], steps in which the rule's condition held.
        usage: int32 [n, R], tau, steps in which it was in the action set.
        quality, strength, error: float32 [n, R], q, zeta and epsilon at the end.
        contribution: int32 [n], delivered packets that the agent had held.
    """

    settings: Settings
    scenario: Scenario
    vocabulary: Vocabulary
    rules: RuleSets | None
    channels: tuple[int, ...]
    ended: bool
    fitness: float
    x: NDArray[np.float32]
    y: NDArray[np.float32]
    holding: NDArray[np.bool_]
    waiting: NDArray[np.int32]
    delivered: NDArray[np.int32]
    heard: NDArray[np.uint32]
    down: NDArray[np.bool_]
    jammer_x: NDArray[np.float32]
    jammer_y: NDArray[np.float32]
    jammed: NDArray[np.int8]
    action: NDArray[np.uint8]
    rule: NDArray[np.int16]
    sent_to: NDArray[np.int8]
    sent_fate: NDArray[np.uint8]
    served: NDArray[np.int8]
    served_fate: NDArray[np.uint8]
    matched: NDArray[np.int32]
    usage: NDArray[np.int32]
    quality: NDArray[np.float32]
    strength: NDArray[np.float32]
    error: NDArray[np.float32]
    contribution: NDArray[np.int32]

    @property
    def steps(self) -> int:
        """T, how many steps the episode took."""
        return len(self.action)

    @property
    def agents(self) -> int:
        """n."""
        return self.x.shape[1]

    @property
    def source(self) -> int:
        """The node that is the source; the sink is the next one."""
        return self.agents

    @property
    def sink(self) -> int:
        """The node that is the sink."""
        return self.agents + 1

    def place(self, moment: int, node: int) -> tuple[float, float]:
        """Where a node was at a moment, m."""
        if node < self.agents:
            return float(self.x[moment, node]), float(self.y[moment, node])
        at = self.scenario.sink if node == self.sink else (0.0, 0.0)
        return float(at[0]), float(at[1])

    def jammer_places(self, moment: int) -> list[tuple[float, float]]:
        """Where the jammers were at a moment, m."""
        return list(zip(self.jammer_x[moment].tolist(), self.jammer_y[moment].tolist(), strict=True))

    def emits(self, jammer: int, moment: int) -> bool:
        """Whether a jammer is taken to disturb the first channel in use at a moment, for maps.

        A reactive one is, since it answers whoever is near; of another it is what it did in the step to come.
        """
        if self.scenario.jammers[jammer].emission == "reactive":
            return True
        return self.steps > 0 and bool(self.jammed[min(moment, self.steps - 1), jammer] == self.channels[0])

    def reach(self, jammer: int) -> float:
        """How far away a jammer's mean power is P_rs, m, without walls."""
        radio, power = self.settings.radio, self.scenario.jammers[jammer].power_db
        return float(radio.network_range * 10 ** (power / (10 * radio.path_loss_exponent)))

    def neighbours(self, step: int) -> NDArray[np.bool_]:
        """Who heard whom in a step: bool [n + 2 node, n agent]."""
        node = np.arange(self.agents + 2)
        return (self.heard[step, node // WORD] >> (node % WORD).astype(np.uint32)[:, None] & np.uint32(1)).astype(bool)

    def to_xarray(self) -> xarray.Dataset:
        """As an xarray Dataset, every variable with its unit and meaning; `dataset.to_dataset`."""
        from slcs2_jax.looking.dataset import to_dataset

        return to_dataset(self)

    def transmissions(self, step: int) -> list[Transmission]:
        """All attempts of a step to hand over a packet, the source's last."""
        found = []
        for agent in np.flatnonzero(self.sent_to[step] != NOBODY).tolist():
            action = self.vocabulary.actions[self.action[step, agent]]
            fate = Fate(self.sent_fate[step, agent])
            found.append(Transmission(agent, int(self.sent_to[step, agent]), action.channel, action.power, fate))
        for place in np.flatnonzero(self.served[step] != NOBODY).tolist():
            asker = int(self.served[step, place])
            power = self.vocabulary.actions[self.action[step, asker]].power
            fate = Fate(self.served_fate[step, place])
            found.append(Transmission(self.source, asker, self.channels[place], power, fate))
        return found


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
