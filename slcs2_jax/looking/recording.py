"""One episode in full, to look at: where everybody was, who sent to whom with what success, which rules acted.

T steps, n agents, R rules, C channels in use. Nodes: agents 0..n-1, source n, sink n + 1.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import Settings
from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.swarm.fate import Fate
from slcs2_jax.world.scenario import Scenario

if TYPE_CHECKING:
    import xarray

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
