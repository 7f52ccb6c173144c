"""The parts beyond the paper's, by the native chunk: held to the definition, and the same bytes however compiled."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.native.choice import beyond
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.world.layout import Jammer
from tests.native.episodes import BATCH, by_native, by_xla, jitted, leaves, make, some_jammers
from tests.native.held import TIPPED, compare, drawn, every_step, random_states, randomly, unlike
from tests.native.plain import joined, some
from tests.native.test_bytes import VARIANTS, assert_same, library, usable, usual

# agents fail in time-steps that follow one from which `compare` makes a step: every thirtieth
FAILING = {"failure_rate": 0.01, "recovery_steps": 30, "failures_at": (31, 61), "failure_share": 0.4}
PARTS: dict[str, dict[str, Any]] = {
    "jammers": {"jammers": some_jammers, "radio": {"fading": "none"}},
    "packets kept": {**FAILING, "failure_keeps_packet": True, "channels": tuple(range(1, 15))},
    "failing for good": {"failures_at": (31,), "radio": {"fading": "rician"}, "channels": (6,)},
    "all": {
        **FAILING,
        "jammers": some_jammers,
        "radio": {"fading": "nakagami", "nakagami_m": 0.8},
        "channels": (3, 7, 9, 14),
    },
}
CELLS = {"jammers": "urban_jammed", "packets kept": "urban", "failing for good": "jammed", "all": "urban_jammed"}
TIPS = 5e-3  # more links and whose is the strongest: more that a rounding can tip
FADINGS: tuple[dict[str, Any], ...] = (
    {"fading": "none"},
    {"fading": "rayleigh"},
    {"fading": "rician", "rician_k": 0.0},
    {"fading": "rician", "rician_k": 30.0},
    {"fading": "nakagami", "nakagami_m": 0.5},
    {"fading": "nakagami", "nakagami_m": 1.0},
    {"fading": "nakagami", "nakagami_m": 20.0},
)


def episodes_of(part: str, **options: Any) -> tuple[Episode, Parameters]:
    """A batch with a part beyond the paper's."""
    return make(CELLS[part], "both", **{"seed": 3, **PARTS[part], **options})


@pytest.mark.parametrize("radio", FADINGS, ids=lambda radio: "-".join(map(str, radio.values())))
def test_links_fade_as_the_definition_says(radio: dict[str, Any]) -> None:
    episode, parameters = make("urban_jammed", "main", jammers=some_jammers, radio=radio)
    found, expected = by_native(episode, parameters, 0), jitted(drawn)(episode, parameters, 0)
    assert not unlike(found, expected).any()
    assert (np.asarray(found.state.power) > 0).any()


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
def test_a_step_is_that_of_the_definition(part: str) -> None:
    episode, parameters = episodes_of(part)
    assert beyond(parameters, episode.arena, episode.given) is None
    compare(episode, parameters, steps=25, tips=TIPS)


@pytest.mark.slow
@settings(max_examples=20)
@given(choice=random_states(), seed=st.integers(0, 2**31))
def test_a_step_from_any_state_is_that_of_the_definition(choice: dict[str, Any], seed: int) -> None:
    episode, parameters = episodes_of("all")
    episode, one = with_news(randomly(episode, choice), seed, choice["spread"]), every_step(parameters)
    found, expected = by_native(episode, one, 1), by_xla(jitted(drawn)(episode, one, 0), one, 1)
    assert unlike(found, expected).sum() <= TIPPED, choice


def with_news(episode: Episode, seed: int, spread: float) -> Episode:
    """With jammers anywhere, agents down, and knowledge of the jammers' places at random."""
    rng, state = np.random.default_rng(seed), episode.state
    known = state.jammers
    assert known is not None
    jammers, n, batch = known.seen_time.shape
    time = np.where(rng.random((jammers, n, batch)) < 0.5, rng.integers(0, 50, (jammers, n, batch)), -1)
    been = (rng.standard_normal((2, 50, jammers, batch)) * spread).astype(np.float32)  # where all were when
    seen_x, seen_y = (
        np.take_along_axis(at.swapaxes(0, 1), np.maximum(time, 0), 1) for at in been
    )  # [J, n, batch], of the same time the same place
    at = rng.uniform(-spread / 3, spread, (2, jammers, batch)).astype(np.float32)
    seen_range = np.where(time >= 0, rng.uniform(1, 300, time.shape), 0).astype(np.float32)
    return dataclasses.replace(
        episode,
        state=dataclasses.replace(
            state,
            node_x=state.node_x.at[-1].set(at[0, 0]),
            node_y=state.node_y.at[-1].set(at[1, 0]),
            down=jnp.asarray(rng.random((n, batch)) < 0.3),
            lost=jnp.asarray(rng.integers(0, 3, batch), jnp.int32),
            jammers=dataclasses.replace(
                known,
                x=jnp.asarray(at[0, 1:]),
                y=jnp.asarray(at[1, 1:]),
                seen_time=jnp.asarray(time, jnp.int32),
                seen_x=jnp.asarray(seen_x),
                seen_y=jnp.asarray(seen_y),
                seen_range=jnp.asarray(seen_range),
            ),
        ),
    )


def test_the_general_way_gives_the_papers_jammer_bit_by_bit() -> None:
    plain, parameters = make("jammed", "both", seed=3)
    arena = plain.arena
    places = np.stack([arena.jammer_x, arena.jammer_y], axis=-1)
    turn = iter(places)
    silent = Jammer(np.zeros(2, np.float32), emission="random", duty=0.0)
    general, _ = make("jammed", "both", seed=3, jammers=lambda _: (Jammer(next(turn)), silent))
    one, other = by_native(plain, parameters, 40), by_native(general, parameters, 40)
    assert np.asarray(one.state.jammer_range).max() > 0
    for name, leaf in leaves((one.state, one.memory)).items():
        assert leaf.tobytes() == leaves((other.state, other.memory))[name].tobytes(), name


@pytest.mark.parametrize("part", PARTS)
def test_every_way_of_compiling_gives_the_same_bytes(part: str) -> None:
    episode, parameters = episodes_of(part)
    expected = usual().advance(episode, parameters, 12)
    for variant in VARIANTS:
        assert_same(library(*usable(variant)).advance(episode, parameters, 12), expected)


def test_neighbours_and_chunks_change_nothing() -> None:
    episode, parameters = episodes_of("all")
    expected = usual().advance(episode, parameters, 40)
    order = np.random.default_rng(0).permutation(BATCH)[:11]
    chunked = some(episode, order)
    for periods in (1, 30, 9):
        chunked = joined(usual().advance(chunked, parameters, periods), chunked)
    assert_same(usual().advance(chunked, parameters, 0), [array[..., order] for array in expected])


OTHERS: tuple[dict[str, Any], ...] = (
    {"radio": {"fading": "nakagami", "nakagami_m": 3.0, "path_loss_exponent": 2.9}, "packets": 2},
    {"failure_rate": 0.05, "recovery_steps": 4, "failures_at": (5, 9), "failure_share": 0.8, "speed": 3.0},
    {"radio": {"fading": "nakagami", "nakagami_m": 0.5, "receive_threshold_dbm": -79.0}, "learning": {"alpha_q": 0.7}},
)


@pytest.mark.parametrize("variant", [None, *VARIANTS])
def test_every_episode_may_have_values_of_its_own(variant: str | None) -> None:
    made = [episodes_of("all", **values) for values in ({}, *OTHERS)]
    alone = [usual().advance(*one, 8) for one in made]
    whose = np.arange(BATCH) % len(made)

    def of_its_own(*each: Any) -> np.ndarray:
        return np.stack([np.asarray(each[which])[..., place] for place, which in enumerate(whose)], axis=-1)

    def laned(*each: Any) -> np.ndarray:
        return np.stack([np.asarray(each[which]) for which in whose], axis=-1)

    episode = jax.tree.map(of_its_own, *(one for one, _ in made))
    parameters = jax.tree.map(laned, *(one for _, one in made))
    found = (library(*usable(variant)) if variant else usual()).advance(episode, parameters, 8)
    assert_same(found, [of_its_own(*arrays) for arrays in zip(*alone, strict=True)])


@pytest.mark.slow
def test_a_decision_list_goes_with_all_parts() -> None:
    compare(*episodes_of("all", rules=20, policy=FirstMatch()), steps=10, tips=TIPS)


@pytest.mark.slow
@pytest.mark.parametrize("agents", [2, 64])
def test_any_swarm_goes_with_all_parts(agents: int) -> None:
    compare(*episodes_of("all", agents=agents, rules=10), steps=6, tips=TIPS)
