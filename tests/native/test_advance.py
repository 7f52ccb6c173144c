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
from slcs2_jax.native import advance as native
from slcs2_jax.native.library import reason_against
from slcs2_jax.policy.first_match import FirstMatch
from tests.native.episodes import ENVIRONMENTS, GRAMMARS, by_native, by_xla, jitted, leaves, make
from tests.native.held import TIPPED, compare, drawn, every_step, random_states, randomly, unlike


def test_the_library_is_there() -> None:
    assert reason_against() is None


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


@settings(max_examples=25)
@given(choice=random_states(), cell=st.sampled_from([("open", "power"), ("urban", "main"), ("urban_jammed", "both")]))
def test_a_step_from_any_state_is_that_of_the_definition(choice: dict[str, Any], cell: tuple[str, str]) -> None:
    episode, parameters = make(*cell)
    episode, one = randomly(episode, choice), every_step(parameters)
    found, expected = by_native(episode, one, 1), by_xla(jitted(drawn)(episode, one, 0), one, 1)
    assert unlike(found, expected).sum() <= TIPPED, choice


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
