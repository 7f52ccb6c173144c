"""The native chunk against the definition: the same step from the same state."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax import episode as episodes
from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.native import advance as native
from slcs2_jax.native.library import reason_against
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.swarm import links
from tests.native.episodes import BATCH, ENVIRONMENTS, GRAMMARS, by_native, by_xla, jitted, leaves, make

# Tolerances, absolute and relative. Places in m differ by their last bits; a distance's change is the difference of two
# distances of up to 1 km, and the logarithm of 1 + it is a reward; powers follow from logarithms of both.
TOLERANCES = {
    "power": (0, 1e-5),
    "interference": (0, 1e-5),
    "_x": (1e-3, 0),
    "_y": (1e-3, 0),
    "jammer_range": (1e-3, 0),
    "reward": (1e-3, 0),
    "recent": (1e-3, 0),
    "quality": (1e-3, 0),
    "error": (1e-3, 0),
    "strength": (1e-2, 1e-5),
}


def test_the_library_is_there() -> None:
    assert reason_against() is None


def every_step(parameters: Parameters) -> Parameters:
    """Sharing and settling after every step, so that one step is all there is."""
    return dataclasses.replace(parameters, sharing_period=1)


def drawn(episode: Episode, parameters: Parameters, _: int = 0) -> Episode:
    """With the links of the step to come as XLA draws them."""
    power = links.draw(episode.state, episode.arena, parameters.physics.radio)
    return dataclasses.replace(episode, state=dataclasses.replace(episode.state, power=power))


def unlike(found: Episode, expected: Episode) -> np.ndarray:
    """In which episodes anything differs by more than the tolerances: bool [B]."""
    wrong: Any = False
    want = leaves((expected.state, expected.memory))
    for name, leaf in leaves((found.state, found.memory)).items():
        other = want[name]
        if leaf.dtype == np.float32:
            absolute, relative = next(one for end, one in TOLERANCES.items() if end in name)
            differs = ~np.isclose(leaf, other, atol=absolute, rtol=relative)
            if "power" in name:
                rows, places = leaf.shape[:2]
                differs[np.arange(rows), np.arange(rows)] = False  # the way to itself, which nobody reads
                parked = np.asarray(~expected.arena.has_jammer)  # nor the way to a jammer that is not there
                row, column = np.indices((rows, places))
                to_jammer = np.where(column >= row, column, places - 1 - row) == places - 1
                to_jammer |= (column < row) & (places - 1 - column == places - 1)
                differs &= ~(to_jammer[..., None] & parked)
                differs[~np.isfinite(other) | (other < 1e-30)] = False
        else:
            differs = leaf != other
        wrong = wrong | differs.reshape(-1, differs.shape[-1]).any(axis=0)
    return wrong


def compare(episode: Episode, parameters: Parameters, steps: int) -> None:
    """Play natively; every step is also made by XLA from the same state."""
    one = every_step(parameters)
    differing = 0
    for _ in range(steps):
        found, expected = by_native(episode, one, 1), by_xla(jitted(drawn)(episode, one, 0), one, 1)
        running = np.asarray(~episodes.over(episode, one))
        differing += int((unlike(found, expected) & running).sum())
        episode = by_native(episode, parameters, 3)
    assert differing <= 1 + steps * BATCH / 1000  # a rounding tips a comparison once in thousands of steps


@pytest.mark.parametrize("grammar", GRAMMARS)
@pytest.mark.parametrize("environment", ENVIRONMENTS)
def test_a_step_is_that_of_the_definition(environment: str, grammar: str) -> None:
    compare(*make(environment, grammar, seed=ENVIRONMENTS.index(environment)), steps=40)


@pytest.mark.slow
@pytest.mark.parametrize("agents", [2, 37, 64])
def test_a_step_of_any_swarm_is_that_of_the_definition(agents: int) -> None:
    compare(*make("urban_jammed", "both", agents=agents, seed=agents), steps=20)


@pytest.mark.slow
def test_a_step_of_a_decision_list_is_that_of_the_definition() -> None:
    compare(*make("urban_jammed", "both", rules=20, policy=FirstMatch()), steps=20)


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
            reward=real((n, batch), 1.0),
            recent=real(memory.recent.shape, 1.0),
        ),
    )


@settings(max_examples=25)
@given(choice=random_states(), cell=st.sampled_from([("open", "power"), ("urban", "main"), ("urban_jammed", "both")]))
def test_a_step_from_any_state_is_that_of_the_definition(choice: dict[str, Any], cell: tuple[str, str]) -> None:
    episode, parameters = make(*cell)
    episode, one = randomly(episode, choice), every_step(parameters)
    found, expected = by_native(episode, one, 1), by_xla(jitted(drawn)(episode, one, 0), one, 1)
    assert unlike(found, expected).sum() <= 1, choice


def test_results_are_those_of_the_definition() -> None:
    """The figures of episodes that are over, from the same last state."""
    episode, parameters = make("open", "main", time_limit=95)
    episode = by_native(episode, parameters, 12)
    found = jax.jit(native.result)(episode, parameters)
    expected = jax.jit(episodes.result)(episode, parameters)
    assert np.asarray(episodes.over(episode, parameters)).all()
    for name, leaf in leaves(found).items():
        np.testing.assert_allclose(leaf, leaves(expected)[name], atol=1e-4, rtol=1e-5, err_msg=name)


def test_a_reflex_acts_whenever_it_holds() -> None:
    episode, parameters = make("open", "main")
    reflex = jnp.asarray(np.random.default_rng(0).random(episode.given.action.shape) < 0.03)
    flagged = dataclasses.replace(episode, given=dataclasses.replace(episode.given, reflex=reflex))
    compare(flagged, parameters, steps=20)
