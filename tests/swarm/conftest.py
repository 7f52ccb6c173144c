"""Small worlds written down by hand: every builder fills in what a test does not care about.

Worlds have no batch axis. Walls always take one block each way, so that worlds of as many agents share programs.
"""

from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import Learning, Radio, Settings, Swarm
from slcs2_jax.swarm import intent, knowledge, links, motion, observation, packets, roles, step
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.outcome import Outcome
from slcs2_jax.swarm.state import initial_state
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import stack
from slcs2_jax.world.geometry import BLOCK
from slcs2_jax.world.scenario import Jammer, Scenario


def _rows(walls):
    return np.asarray(walls, np.float32).reshape(-1, 3)


@jax.jit
def _measure(state, arena, radio):
    return links.measure(dataclasses.replace(state, power=links.draw(state, arena, radio)), arena, radio)


def _look(state, measured, arena, physics):
    alive = physics.task.running(state, arena, physics.swarm)
    everybody = roles.candidates(state, arena)
    return observation.look(state, measured, everybody, arena, physics.radio, physics.swarm, alive)


@jax.jit
def _see(state, measured, arena, physics):
    return observation.observe(_look(state, measured, arena, physics), physics.language)


@jax.jit
def _reward(view, after, meant, air, physics):
    return physics.task.worth(view, after, Outcome(meant, air))


@jax.jit
def _resolve(state, step_x, step_y, arena, parameters):
    return motion.resolve(state, step_x, step_y, arena, parameters)


class Plain:
    """One agent's view in plain Python and double precision (model section 4). Nodes: agents, source n, sink n + 1."""

    def __init__(self, state, arena, heard, me):
        n = state.x.shape[0]
        self.n, self.me = n, me
        self.here = (float(state.x[me]), float(state.y[me]))
        self.others = [(float(state.x[j]), float(state.y[j])) for j in range(n) if j != me]
        estimate = (float(arena.estimate_x), float(arena.estimate_y))
        known = [j for j in range(n) if state.known_time[j, me] >= 0]
        self.place = {j: (float(state.known_x[j, me]), float(state.known_y[j, me])) for j in known}
        self.place |= {n: (0.0, 0.0), n + 1: estimate}
        self.heard = [j for j in range(n + 2) if heard[j, me]]
        self.goal = {"so": (0.0, 0.0), "si": estimate}

    def role(self, name, only_heard=False):
        """The node with a role among those known, or heard; None if undefined."""
        if name in ("source", "sink"):
            node = self.n + (name == "sink")
            return node if not only_heard or node in self.heard else None
        members = [j for j in sorted(self.place) if not only_heard or j in self.heard]
        if name != "c":
            goal = self.goal[name]
            members = [j for j in members if math.dist(self.place[j], goal) < math.dist(self.here, goal)]
        return min(members, key=lambda j: math.dist(self.place[j], self.here), default=None)

    def distance(self, name):
        """Distance to a role, m; None if undefined."""
        node = self.role(name)
        return None if node is None else math.dist(self.place[node], self.here)


class Make:
    """Builders of a world, and the public functions of the room compiled."""

    measure = staticmethod(_measure)
    look = staticmethod(jax.jit(_look))
    see = staticmethod(_see)
    enter = staticmethod(jax.jit(knowledge.update))
    share = staticmethod(jax.jit(knowledge.share))
    candidates = staticmethod(jax.jit(roles.candidates))
    interpret = staticmethod(jax.jit(intent.interpret, static_argnums=2))
    transfer = staticmethod(jax.jit(packets.transfer))
    proposed_step = staticmethod(jax.jit(motion.proposed_step))
    resolve = staticmethod(_resolve)
    reward = staticmethod(_reward)
    observe = staticmethod(jax.jit(step.observe))
    act = staticmethod(jax.jit(step.act))

    @staticmethod
    def physics(*, radio=None, learning=None, **swarm):
        """Parameters: radio and learning by a dictionary, the swarm's by name."""
        sections = {"radio": Radio(**radio or {}), "swarm": Swarm(**swarm), "learning": Learning(**learning or {})}
        return Physics.of(Settings(**sections))

    @staticmethod
    def arena(
        places, *, sink=(600, 0), estimate=None, jammer=None, vertical=(), horizontal=(), channels=(0,), width=None,
        time_limit=1000,
    ):  # fmt: skip
        """A world with the agents' starts [n, 2]; walls as rows (at, low, high)."""
        scenario = Scenario(
            environment="by hand",
            seed=0,
            sink=np.array(sink, np.float32),
            sink_estimate=np.array(sink if estimate is None else estimate, np.float32),
            jammers=() if jammer is None else (Jammer(np.array(jammer, np.float32)),),
            vertical=_rows(vertical),
            horizontal=_rows(horizontal),
            wall_thickness=1.0,
            start=np.array(places, np.float32),
            time_limit=time_limit,
        )
        width = max(channels) + 1 if width is None else width
        stacked = stack([scenario], [channels], capacity=(BLOCK, BLOCK), width=width)
        return jax.tree.map(lambda leaf: jnp.asarray(leaf[..., 0]), stacked)

    @staticmethod
    def state(arena, *, key=(1, 2), count=300, **fields):
        """The swarm as deployed, with the fields given in its place; a list of agents that hold a packet is enough."""
        noise = Make.physics().radio.noise
        state = initial_state(arena, jnp.array(key, jnp.uint32), jnp.int32(count), noise)
        n = state.x.shape[0]
        if "holding" in fields and not hasattr(fields["holding"], "dtype"):
            held = np.isin(np.arange(n), fields["holding"])
            fields["holding"] = held
            history = np.zeros(state.history.shape, np.uint32)
            agents = np.arange(n)
            history[agents // 32, agents] = np.where(held, np.uint32(1) << np.uint32(agents % 32), 0)
            fields.setdefault("history", history)
            fields.setdefault("waiting", count - int(held.sum()))
        cast = {name: jnp.asarray(value, getattr(state, name).dtype) for name, value in fields.items()}
        for name, value in cast.items():
            assert value.shape == getattr(state, name).shape, name
        return dataclasses.replace(state, **cast)

    @staticmethod
    def know(state, entries):
        """Let agents know of others: {(self, other): (time, x, y)}."""
        time, x, y = (np.array(a) for a in (state.known_time, state.known_x, state.known_y))
        for (me, other), (when, px, py) in entries.items():
            time[other, me], x[other, me], y[other, me] = when, px, py
        return dataclasses.replace(state, known_time=jnp.asarray(time), known_x=jnp.asarray(x), known_y=jnp.asarray(y))

    @staticmethod
    def links(n, powers=None, *, default=0.0, jamming=None, heard=None, channels=1):
        """Links by hand: powers {(u, v): mW} both ways; heard {(self, other)}, by default all."""
        power = np.full((n + 2, n + 2), default, np.float32)
        for (u, v), mw in (powers or {}).items():
            power[u, v] = power[v, u] = mw
        np.fill_diagonal(power, 0)
        noise = np.zeros((channels, n + 2), np.float32) if jamming is None else np.asarray(jamming, np.float32)
        ears = np.zeros((n + 2, n), bool)
        if heard is None:
            ears[:] = True
            ears[np.arange(n), np.arange(n)] = False
        else:
            for me, other in heard:
                ears[other, me] = True
        return Links(power=jnp.asarray(power), jamming=jnp.asarray(noise), heard=jnp.asarray(ears))

    @staticmethod
    def intent(n, *, moves=None, collects=None, sends=None):
        """Intents by hand.

        moves: {agent: (direction, x, y)}, target unknown if x is None; collects: {agent: (channel, level)};
        sends: {agent: (node, channel, level)}.
        """
        table = {
            "acts": np.zeros(n, bool),
            "moves": np.zeros(n, bool),
            "collects": np.zeros(n, bool),
            "sends": np.zeros(n, bool),
            "direction": np.zeros(n, np.int32),
            "place_x": np.zeros(n, np.float32),
            "place_y": np.zeros(n, np.float32),
            "place_known": np.zeros(n, bool),
            "node": np.full(n, n + 2, np.int32),
            "channel": np.zeros(n, np.int32),
            "level": np.ones(n, np.float32),
        }
        for i, (direction, x, y) in (moves or {}).items():
            table["moves"][i] = table["acts"][i] = True
            table["direction"][i] = direction
            if x is not None:
                table["place_x"][i], table["place_y"][i], table["place_known"][i] = x, y, True
        for i, (channel, level) in (collects or {}).items():
            table["collects"][i] = table["acts"][i] = True
            table["channel"][i], table["level"][i] = channel, level
        for i, (node, channel, level) in (sends or {}).items():
            table["sends"][i] = table["acts"][i] = True
            table["node"][i], table["channel"][i], table["level"][i] = node, channel, level
        return intent.Intent(**jax.tree.map(jnp.asarray, table))

    @staticmethod
    def view(rng, *, n=5, channels=(0, 1, 2), jammer=True, size=150.0, physics=None, **options):
        """A random world in which agents know and hear some others: (state, links, arena), in NumPy."""
        arena = Make.arena(
            rng.uniform(-size / 3, size, (n, 2)), sink=(size, size / 4), estimate=(size + 5, size / 4 - 3),
            jammer=rng.uniform(0, size, 2) if jammer else None, channels=channels, width=3, **options,
        )  # fmt: skip
        holding = rng.random(n) < 0.5
        state = Make.state(
            arena,
            t=20,
            holding=np.flatnonzero(holding).tolist(),
            jammer_range=np.where(rng.random(n) < 0.5, rng.uniform(5, 1.2 * size, n), 0),
            interference=10 ** rng.uniform(-9.4, -7, (3, n)),
        )
        some = {(i, j): (int(rng.integers(0, 20)), *rng.uniform(-size / 3, size, 2))
                for i in range(n) for j in range(n) if i != j and rng.random() < 0.5}  # fmt: skip
        heard = [(i, j) for i in range(n) for j in range(n + 2) if i != j and rng.random() < 0.4]
        measured = Make.links(n, heard=heard, channels=3)
        radio = (physics or Make.physics()).radio
        return jax.device_get((Make.enter(Make.know(state, some), measured, arena, radio), measured, arena))

    plain = Plain
    replace = staticmethod(dataclasses.replace)


@pytest.fixture(scope="session")
def make():
    """The builders."""
    return Make
