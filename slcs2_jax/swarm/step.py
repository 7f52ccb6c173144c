"""One time-step of the world: observe, then act (spec sections 3 and 4)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.settings import Settings
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.swarm import intent as intents
from slcs2_jax.swarm import knowledge, links, motion, observation, packets, reward, roles
from slcs2_jax.swarm.failure import who_is_down
from slcs2_jax.swarm.intent import Intent
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.packets import Air
from slcs2_jax.swarm.state import State, SwarmParameters, initial_state, running
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.radio import RadioParameters


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Physics:
    """The parameters of the world, every leaf a scalar."""

    radio: RadioParameters
    swarm: SwarmParameters

    @classmethod
    def of(cls, settings: Settings) -> Physics:
        """Take the values from the settings."""
        return cls(RadioParameters.of(settings.radio), SwarmParameters.of(settings))


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a step brought.

    Attributes:
        reward: float32 [n, ...], rho; meaningless for agents that did not act.
        acts: bool [n, ...], who acted.
        intent: what everybody was about.
        air: the transmissions.
    """

    reward: jax.Array
    acts: jax.Array
    intent: Intent
    air: Air


def observe(state: State, arena: Arena, physics: Physics) -> tuple[State, Links, Observation]:
    """Take the links drawn for the step, take in what is heard, and show each agent its view."""
    drawn = links.measure(state, arena, physics.radio)
    state = knowledge.update(state, drawn, arena, physics.radio)
    everybody = roles.candidates(state, arena)
    alive = running(state, arena, physics.swarm)
    seen = observation.observe(state, drawn, everybody, arena, physics.radio, physics.swarm, alive)
    if state.down is not None:  # nothing is true for who is down
        seen = dataclasses.replace(seen, truth=jnp.where(state.down, np.uint32(0), seen.truth))
    return state, drawn, seen


def act(
    state: State, action: jax.Array, seen: Observation, drawn: Links, arena: Arena, physics: Physics
) -> tuple[State, Outcome]:
    """Carry out everybody's action at once.

    Args:
        state: as ``observe`` left it.
        action: int32 [n, ...], numbers of the vocabulary; ``NO_ACTION`` for none.
        seen, drawn: what ``observe`` returned.
        arena, physics: the scenario and the parameters.
    """
    if state.down is not None:
        action = jnp.where(state.down, np.int32(NO_ACTION), action)
    intent = intents.interpret(action, seen, state, arena, physics.radio, physics.swarm)
    moved_packets, air = packets.transfer(state, drawn, intent, physics.radio)
    step = motion.proposed_step(state, intent, physics.swarm)
    x, y = motion.resolve(state, *step, arena, physics.swarm)
    moved_packets = links.moved_jammers(moved_packets, seen.running, arena, physics.radio)
    after = dataclasses.replace(
        moved_packets,
        node_x=moved_packets.node_x.at[:-3].set(x),
        node_y=moved_packets.node_y.at[:-3].set(y),
        t=state.t + seen.running.astype(jnp.int32),
    )
    after = failed(links.drawn(after, arena, physics.radio), seen.running, physics.swarm)
    gained = reward.reward(state, after, air, intent, arena, physics.swarm)
    return after, Outcome(gained, intent.acts, intent, air)


def begin(arena: Arena, key: jax.Array, physics: Physics) -> State:
    """The swarm as deployed (key uint32 [2, ...]), with the links of the first step."""
    failing = physics.swarm.failures is not None
    state = initial_state(arena, key, physics.swarm.packets, physics.radio.noise, failing=failing)
    alive = running(state, arena, physics.swarm)
    return failed(links.drawn(state, arena, physics.radio), alive, physics.swarm)


def failed(state: State, alive: jax.Array, parameters: SwarmParameters) -> State:
    """The state with those down that do not work in time-step ``state.t``, without the packets that they so lose.

    alive: bool [...], whether the episode goes on.
    """
    if parameters.failures is None or state.down is None or state.lost is None:
        return state
    down = jnp.where(alive, who_is_down(state.down, state.key, state.t, parameters.failures), state.down)
    state = dataclasses.replace(state, down=down)
    if parameters.failures.keeps_packet:
        return state
    loses = down & state.holding
    return dataclasses.replace(
        state,
        holding=state.holding & ~loses,
        history=jnp.where(loses, np.uint32(0), state.history),
        lost=state.lost + jnp.sum(loses, axis=0, dtype=jnp.int32),
    )
