"""What an agent observes: the truth of every clause, a vector of figures, and what it could do (paper, Appendix A)."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import LEFT
from slcs2_jax.swarm import clauses
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.roles import Candidates, closest
from slcs2_jax.swarm.state import State, SwarmParameters
from slcs2_jax.swarm.view import View
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.radio import RadioParameters
from slcs2_jax.world.stored import kept, stored


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Observation:
    """All that a policy may base a decision on.

    Attributes:
        truth: uint32 [W, n, ...], bit k % 32 of word k // 32 tells whether clause k of the vocabulary holds; nothing
            holds for the agents of an episode that is over, or for one that is down.
        view: what else there is to see, for policies of another kind; `features` makes a vector of it.
    """

    truth: jax.Array
    view: View


def look(
    state: State,
    links: Links,
    everybody: Candidates,
    arena: Arena,
    radio: RadioParameters,
    parameters: SwarmParameters,
    running: jax.Array,
) -> View:
    """Put together what there is to see in a time-step."""
    known = everybody.known
    sides = [known & everybody.source_side, known & everybody.sink_side, known]
    roles = [closest(side, everybody.squared) for side in sides]
    to_sink = jnp.sqrt((arena.estimate_x - state.x) ** 2 + (arena.estimate_y - state.y) ** 2)
    to_source = jnp.sqrt(state.x**2 + state.y**2)
    left = kept((*roles, to_sink, to_source))
    everywhere = jnp.ones_like(state.x)
    jammer = jnp.where(state.jammer_range > 0, state.jammer_range, jnp.inf)
    return View(
        state=state,
        arena=arena,
        links=links,
        everybody=everybody,
        left=left,
        right=(*left[:3], everywhere * parameters.distance_threshold, everywhere * radio.network_range, jammer),
        node_heard=jnp.any(links.heard[-2:], axis=0),
        running=running,
        radio=radio,
        swarm=parameters,
    )


def observe(view: View, language: Language) -> Observation:
    """Form each agent's observation."""
    return Observation(stored(clauses.truth(view, language), view.swarm.speed), view)


class Feature(NamedTuple):
    """An entry of the vector that `features` makes: what it is, the unit of what it measures, and how it is scaled."""

    name: str
    unit: str
    scale: str


def feature_list(channels: int) -> tuple[Feature, ...]:
    """The entries of `features` for a swarm with so many channels, in order."""
    over_net, flag = "divided by net, at most 10; 10 if undefined", "0 or 1"
    return (
        *(Feature(name, "m", over_net) for name in LEFT),
        Feature("xi, range of the nearest known jammer", "m", over_net),
        Feature("packet held", "", flag),
        Feature("source or sink heard", "", flag),
        Feature("jammer known", "", flag),
        Feature("agents heard", "agents", "share of the other agents"),
        *(Feature(f"NI on channel {k}", "dB", "over P_rs, divided by 30 dB") for k in range(channels)),
        Feature("time", "steps", "share of the time limit"),
        Feature("x", "m", "along the line to the sink, share of the distance to it"),
        Feature("y", "m", "across that line, divided by net"),
    )


def features(view: View, channels: int | None = None) -> jax.Array:
    """What each agent observes as one vector: float32 [F, n, ...], entries as `feature_list` says.

    channels: of these many channels, the first; None is all that there are.
    """
    state, net = view.state, view.radio.network_range
    n = state.x.shape[0]
    most = np.float32(10)

    def near(distance: jax.Array) -> jax.Array:
        return jnp.minimum(distance / net, most)

    def flag(true: jax.Array) -> jax.Array:
        return true.astype(jnp.float32)

    decibels = np.float32(10 / np.log2(10.0)) * jnp.log2(state.interference[:channels] / view.radio.sensitivity)
    others = jnp.sum(view.heard[:n].astype(jnp.float32), axis=0) - flag(view.heard[np.arange(n), np.arange(n)])
    time = state.t.astype(jnp.float32) / jnp.maximum(view.arena.time_limit, np.int32(1)).astype(jnp.float32)
    ahead = jnp.sqrt(view.arena.estimate_x**2 + view.arena.estimate_y**2)
    entries = [
        *(near(distance) for distance in view.left),
        near(view.right[-1]),
        flag(state.holding),
        flag(view.node_heard),
        flag(state.jammer_range > 0),
        others / np.float32(max(n - 1, 1)),
        *(level / np.float32(30) for level in decibels),
        jnp.broadcast_to(time, state.x.shape),
        state.x / jnp.maximum(ahead, np.float32(1)),
        state.y / net,
    ]
    return jnp.stack(entries)
