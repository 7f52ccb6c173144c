"""Holding native steps to those of the definition, from any state."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import strategies as st

from slcs2_jax import episode as episodes
from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.policy import bits
from slcs2_jax.swarm import links
from tests.native.episodes import BATCH, by_native, by_xla, jitted, leaves

# Tolerances, absolute and relative. Places in m differ by their last bits; a distance's change is the difference of two
# distances of up to 1 km, and the logarithm of 1 + it is a reward; powers follow from logarithms of both, and between
# those that are near each other from the last bits of places: jammers come as near as they like.
TOLERANCES = {
    "jammers.power": (0, 2e-4),
    "power": (0, 3e-5),
    "interference": (0, 1e-5),
    "x": (1e-3, 0),
    "y": (1e-3, 0),
    "range": (1e-3, 0),
    "reward": (1e-3, 0),
    "recent": (1e-3, 0),
    "quality": (1e-3, 0),
    "error": (1e-3, 0),
    "strength": (1e-2, 1e-5),
}

TIPPED = 3  # of a batch in any state: where all stand within 4 m a rounding tips one step in fifty


def every_step(parameters: Parameters) -> Parameters:
    """Sharing and settling after every step, so that one step is all there is."""
    return dataclasses.replace(parameters, sharing_period=1)


def drawn(episode: Episode, parameters: Parameters, _: int = 0) -> Episode:
    """With the links of the step to come as XLA draws them."""
    return dataclasses.replace(episode, state=links.drawn(episode.state, episode.arena, parameters.physics.radio))


def unlike(found: Episode, expected: Episode) -> np.ndarray:
    """In which episodes anything differs by more than the tolerances: bool [B]."""
    wrong: Any = False
    want = leaves((expected.state, expected.memory))
    for name, leaf in leaves((found.state, found.memory)).items():
        other = want[name]
        if leaf.dtype == np.float32:
            absolute, relative = next(one for end, one in TOLERANCES.items() if name.endswith(end))
            differs = ~np.isclose(leaf, other, atol=absolute, rtol=relative)
            if name == "[0].power":
                rows, places = leaf.shape[:2]
                differs[np.arange(rows), np.arange(rows)] = False  # the way to itself, which nobody reads
                parked = np.asarray(~expected.arena.has_jammer)  # nor the way to a jammer that is not there
                row, column = np.indices((rows, places))
                to_jammer = np.where(column >= row, column, places - 1 - row) == places - 1
                to_jammer |= (column < row) & (places - 1 - column == places - 1)
                differs &= ~(to_jammer[..., None] & parked)
                differs[~np.isfinite(other) | (other < 1e-30)] = False
            if "jammers.power" in name:
                differs &= np.asarray(expected.arena.emitters.exists)[1:, None]
        else:
            differs = leaf != other
        wrong = wrong | differs.reshape(-1, differs.shape[-1]).any(axis=0)
    return wrong


def compare(episode: Episode, parameters: Parameters, steps: int, *, tips: float = 1e-3) -> None:
    """Play natively; every step is also made by XLA from the same state.

    tips: chance that a rounding tips a comparison in an episode's step.
    """
    one = every_step(parameters)
    differing = 0
    for _ in range(steps):
        found, expected = by_native(episode, one, 1), by_xla(jitted(drawn)(episode, one, 0), one, 1)
        running = np.asarray(~episodes.over(episode, one))
        differing += int((unlike(found, expected) & running).sum())
        episode = by_native(episode, parameters, 3)
    assert differing <= 1 + steps * BATCH * tips


@st.composite
def random_states(draw: Any) -> dict[str, Any]:
    """What makes a state that no episode need ever have come to."""
    return {
        "seed": draw(st.integers(0, 2**31)),
        "spread": draw(st.sampled_from([3.0, 30.0, 200.0, 600.0])),
        "known": draw(st.floats(0, 1)),
        "held": draw(st.floats(0, 1)),
        "waiting": draw(st.integers(0, 5)),
        "quality": draw(st.sampled_from([0.0, 1e-3, 1.0, 100.0])),
    }


def randomly(episode: Episode, choice: dict[str, Any]) -> Episode:
    """The episode in a random state: places, knowledge, packets and what has been learnt."""
    rng = np.random.default_rng(choice["seed"])
    state, memory, arena = episode.state, episode.memory, episode.arena
    n, batch = state.x.shape
    place = rng.uniform(-choice["spread"] / 3, choice["spread"], (2, n, batch)).astype(np.float32)
    known = rng.random((n, n, batch)) < choice["known"]
    known &= ~np.eye(n, dtype=bool)[..., None]
    time = np.where(known, rng.integers(0, 50, known.shape), -1)
    been = (rng.standard_normal((2, 50, n, batch)) * choice["spread"]).astype(np.float32)  # where everybody was when
    known_x, known_y = (
        np.where(known, np.take_along_axis(at, time.swapaxes(0, 1), 0).swapaxes(0, 1), 0) for at in been
    )
    holding = rng.random((n, batch)) < choice["held"]
    history = rng.integers(0, 2**32, state.history.shape, dtype=np.uint32) & np.uint32((1 << min(n, 32)) - 1)
    rules = episode.given.action.shape

    def real(shape: tuple[int, ...], scale: float) -> jax.Array:
        return jnp.asarray((rng.standard_normal(shape) * scale).astype(np.float32))

    trace = rng.integers(0, 2**32, rules, dtype=np.uint32) & rng.integers(0, 2**32, rules, dtype=np.uint32)
    return dataclasses.replace(
        episode,
        state=dataclasses.replace(
            state,
            t=jnp.asarray(rng.integers(50, 1000, batch), jnp.int32),
            node_x=state.node_x.at[:n].set(place[0]),
            node_y=state.node_y.at[:n].set(place[1]),
            known_time=jnp.asarray(time, jnp.int32),
            known_x=jnp.asarray(known_x, jnp.float32),
            known_y=jnp.asarray(known_y, jnp.float32),
            jammer_range=jnp.asarray((rng.random((n, batch)) < 0.5) * rng.uniform(5, 300, (n, batch)), jnp.float32)
            * jnp.asarray(arena.has_jammer, jnp.float32),
            holding=jnp.asarray(holding),
            history=jnp.asarray(np.where(holding, history, 0).astype(np.uint32)),
            waiting=jnp.full(batch, choice["waiting"], jnp.int32),
            interference=jnp.asarray(10 ** rng.uniform(-9.4, -7, state.interference.shape), jnp.float32),
        ),
        memory=dataclasses.replace(
            memory,
            quality=real(rules, choice["quality"]),
            error=jnp.abs(real(rules, 1.0)),
            strength=real(rules, 1.0),
            usage=jnp.asarray(rng.integers(40, 100, rules), jnp.int32),
            trace=jnp.asarray(trace),
            members=bits.pack(jnp.asarray(trace & 1 == 1)),
            reward=real((n, batch), 1.0),
            recent=real(memory.recent.shape, 1.0),
        ),
    )
