"""One time-step of the world: observe, then act (spec sections 3 and 4)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from slcs2_jax.config.settings import Settings
from slcs2_jax.swarm import intent as intents
from slcs2_jax.swarm import knowledge, links, motion, observation, packets, reward, roles
from slcs2_jax.swarm.intent import Intent
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.packets import Air
from slcs2_jax.swarm.state import State, SwarmParameters, running
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
    intent = intents.interpret(action, seen, state, arena, physics.radio, physics.swarm)
    moved_packets, air = packets.transfer(state, drawn, intent, physics.radio)
    step = motion.proposed_step(state, intent, physics.swarm)
    x, y = motion.resolve(state, *step, arena, physics.swarm)
    after = dataclasses.replace(
        moved_packets,
        node_x=state.node_x.at[:-3].set(x),
        node_y=state.node_y.at[:-3].set(y),
        t=state.t + seen.running.astype(jnp.int32),
    )
    after = dataclasses.replace(after, power=links.draw(after, arena, physics.radio))
    gained = reward.reward(state, after, air, intent, arena, physics.swarm)
    return after, Outcome(gained, intent.acts, intent, air)
