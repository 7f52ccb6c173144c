"""One time-step of the world: observe, then act (paper, sections on the environment and the agents)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config.settings import Settings
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.swarm import intent as intents
from slcs2_jax.swarm import knowledge, links, motion, observation, packets, roles
from slcs2_jax.swarm.failure import who_is_down
from slcs2_jax.swarm.observation import Observation
from slcs2_jax.swarm.outcome import Outcome
from slcs2_jax.swarm.state import OTHER_NODES, State, SwarmParameters, initial_state, lift
from slcs2_jax.swarm.task import Delivery, task_of
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.radio import RadioParameters


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Physics:
    """The world's parameters, every leaf a scalar; what can be said and done in it, and the task, are code."""

    radio: RadioParameters
    swarm: SwarmParameters
    language: Language = dataclasses.field(default=Language(), metadata={"static": True})
    task: Delivery = dataclasses.field(default=Delivery(), metadata={"static": True})

    @classmethod
    def of(cls, settings: Settings, language: Language | None = None) -> Physics:
        """Take the values from the settings."""
        radio, swarm = RadioParameters.of(settings.radio), SwarmParameters.of(settings)
        return cls(radio, swarm, language or Language(), task_of(settings))


def observe(state: State, arena: Arena, physics: Physics) -> tuple[State, Observation]:
    """Take the links drawn for the step, take in what is heard, and show each agent its view."""
    drawn = links.measure(state, arena, physics.radio)
    state = knowledge.update(state, drawn, arena, physics.radio)
    everybody = roles.candidates(state, arena)
    running = physics.task.running(state, arena, physics.swarm)
    view = observation.look(state, drawn, everybody, arena, physics.radio, physics.swarm, running)
    return state, observation.observe(view, physics.language)


def act(action: jax.Array, seen: Observation, physics: Physics) -> tuple[State, jax.Array, Outcome]:
    """Carry out everybody's action at once.

    Args:
        action: int32 [n, ...], numbers of the vocabulary; ``NO_ACTION`` for none.
        seen: what ``observe`` returned.
        physics: the parameters.

    Returns:
        The next state; the reward, float32 [n, ...], meaningless for agents that did not act; and what happened.
    """
    view = seen.view
    state, arena = view.state, view.arena
    if state.down is not None:
        action = jnp.where(state.down, np.int32(NO_ACTION), action)
    intent = intents.interpret(action, view, physics.language)
    moved_packets, air = packets.transfer(state, view.links, intent, physics.radio)
    step = motion.proposed_step(state, intent, physics.swarm)
    x, y = motion.resolve(state, *step, arena, physics.swarm)
    moved_packets = links.moved_jammers(moved_packets, view.running, arena, physics.radio)
    after = dataclasses.replace(
        moved_packets,
        node_x=_replaced(moved_packets.node_x, x),
        node_y=_replaced(moved_packets.node_y, y),
        t=state.t + view.running.astype(jnp.int32),
    )
    after = failed(links.drawn(after, arena, physics.radio), view.running, physics.swarm)
    outcome = Outcome(intent, air)
    return after, physics.task.worth(view, after, outcome), outcome


def _replaced(nodes: jax.Array, agents: jax.Array) -> jax.Array:
    """Coordinates of all nodes with those of the agents replaced: in place where that saves a copy."""
    return jax.lax.platform_dependent(
        nodes,
        agents,
        cpu=lambda nodes, agents: nodes.at[:-OTHER_NODES].set(agents),
        default=lambda nodes, agents: jnp.where(
            lift(np.arange(nodes.shape[0]) < agents.shape[0], nodes[0]),
            jnp.pad(agents, ((0, OTHER_NODES), *((0, 0),) * (agents.ndim - 1))),
            nodes,
        ),
    )


def begin(arena: Arena, key: jax.Array, physics: Physics) -> State:
    """The swarm as deployed (key uint32 [2, ...]), with the links of the first step."""
    failing = physics.swarm.failures is not None
    state = initial_state(arena, key, physics.swarm.packets, physics.radio.noise, failing=failing)
    running = physics.task.running(state, arena, physics.swarm)
    return failed(links.drawn(state, arena, physics.radio), running, physics.swarm)


def failed(state: State, running: jax.Array, parameters: SwarmParameters) -> State:
    """The state with those down that do not work in time-step ``state.t``, without the packets that they so lose.

    running: bool [...], whether the episode goes on.
    """
    if parameters.failures is None:
        return state
    assert state.down is not None  # for the type checker
    assert state.lost is not None
    down = jnp.where(running, who_is_down(state.down, state.key, state.t, parameters.failures), state.down)
    if parameters.failures.keeps_packet:
        return dataclasses.replace(state, down=down)
    loses = down & state.holding
    return dataclasses.replace(
        state,
        down=down,
        holding=state.holding & ~loses,
        history=jnp.where(loses, np.uint32(0), state.history),
        lost=state.lost + jnp.sum(loses, axis=0, dtype=jnp.int32),
    )
