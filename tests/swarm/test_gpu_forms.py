"""What is written in another form for GPUs means the same: those forms, run on the CPU, give the same steps."""

from __future__ import annotations

import contextlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax import episode as episodes
from slcs2_jax.config import Settings, Swarm, World
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar import load_grammar, random_rules
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm import knowledge, packets, selection
from slcs2_jax.world import geometry
from slcs2_jax.world.arena import PADDING, stack, wall_capacity
from slcs2_jax.world.geometry import Lines, Walls
from slcs2_jax.world.scenario import make_scenario
from slcs2_jax.world.stored import kept

AGENTS, RULES, EPISODES = 5, 30, 4


@contextlib.contextmanager
def forms_for_gpus():
    """Trace what GPUs compile, wherever it is run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jax.lax, "platform_dependent", lambda *given, cpu, default: default(*given))
        yield


def both(function, *given):
    """What it gives in either form, operation by operation: no compiler rounds in between."""
    with jax.disable_jit():
        ours = function(*given)
        with forms_for_gpus():
            return ours, function(*given)


def same(function, *given):
    """Check that both forms give the same bits."""
    ours, theirs = both(function, *given)
    jax.tree.map(np.testing.assert_array_equal, ours, theirs)
    return ours


def places(rng, *shape):
    return jnp.asarray(rng.uniform(0, 100, shape), jnp.float32)


def walls(rng, count, batch):
    """Random walls, the last of each kind padding."""

    def lines():
        at, low = rng.uniform(0, 100, (2, count, batch))
        high = low + rng.uniform(1, 40, (count, batch))
        at[-1], low[-1], high[-1] = PADDING
        return Lines(*(jnp.asarray(a, jnp.float32) for a in (at, low, high)))

    return Walls(lines(), lines())


def test_walls_are_counted_and_found_alike():
    rng = np.random.default_rng(0)
    town = walls(rng, geometry.BLOCK, EPISODES)
    ends = [places(rng, 3, 4, EPISODES) for _ in range(4)]
    assert same(geometry.count_crossings, *ends, town).max() > 1
    here = [places(rng, 6, EPISODES) for _ in range(4)]
    half, limit = jnp.float32(0.5), jnp.float32(16)
    same(geometry.nearest_wall, *here[:2], half, town)
    found = same(geometry.blocking_wall, *here, limit, half, town)
    assert jnp.isfinite(found.squared).any()
    assert not jnp.isfinite(found.squared).all()
    nothing = jax.tree.map(lambda a: jnp.broadcast_to(a[-1:], a.shape), town)  # padding alone
    assert jnp.isinf(same(geometry.nearest_wall, *here[:2], half, nothing).squared).all()


def test_the_least_is_found_alike_with_ties_and_with_nobody_eligible():
    rng = np.random.default_rng(1)
    score = jnp.asarray(rng.integers(0, 3, (7, 50, EPISODES)), jnp.float32)
    eligible = jnp.asarray(rng.random(score.shape) < 0.3)
    index, best = same(selection.least, eligible, score, jnp.float32(1))
    nobody = ~eligible.any(axis=0)
    assert nobody.any()
    assert (index[nobody] == 7).all()
    assert jnp.isinf(best[nobody]).all()


def test_other_signals_add_up_alike():
    rng = np.random.default_rng(2)
    signal = np.float32(rng.integers(0, 3, (6, 8, EPISODES)))
    signal[:, 0] = 0  # silence
    same(packets.others, jnp.asarray(signal))


def _batch():
    rng = np.random.default_rng(3)
    grammar = load_grammar("main")
    made = Settings(world=World.preset("urban_jammed"), swarm=Swarm(agents=AGENTS))
    scenarios = [make_scenario(made, seed) for seed in range(EPISODES)]
    drawn = [random_rules(grammar, AGENTS * RULES, rng) for _ in scenarios]
    mask = np.stack([m.reshape(AGENTS, RULES, -1) for m, _ in drawn], -1).transpose(2, 1, 0, 3)
    action = np.stack([a.reshape(AGENTS, RULES) for _, a in drawn], -1).transpose(1, 0, 2)
    channels = [grammar.channels_used] * EPISODES
    arena = stack(scenarios, channels, capacity=wall_capacity(scenarios), width=1 + max(grammar.channels_used))
    key = rng.integers(0, 2**32, (2, EPISODES), dtype=np.uint32)
    return jax.tree.map(jnp.asarray, (arena, Rules(mask, action), key)), Parameters.of(made)


@pytest.mark.slow
def test_steps_of_episodes_are_the_same():
    given, parameters = _batch()
    episode = jax.jit(episodes.begin)(*given, parameters)

    def step(episode):
        episode, _ = episodes.step(episode, parameters)
        return episode, knowledge.share(episode.state)

    ours = jax.jit(lambda episode: step(episode))
    theirs = jax.jit(lambda episode: step(episode))
    with forms_for_gpus():
        theirs = theirs.lower(episode).compile()
    for _ in range(60):
        expected, found = ours(episode), theirs(episode)
        jax.tree.map(_alike, expected, found)
        episode = expected[0]
    assert (episode.state.known_time >= 0).any()


def _alike(expected, found):
    assert expected.dtype == found.dtype
    if jnp.issubdtype(expected.dtype, jnp.floating):
        np.testing.assert_allclose(expected, found, rtol=2e-5, atol=1e-4)
    else:
        np.testing.assert_array_equal(expected, found)


def test_what_is_kept_is_kept_on_gpus_only_and_unchanged():
    tree = (jnp.arange(3), {"nothing": jnp.zeros((0, 2), jnp.uint8)})
    jax.tree.map(np.testing.assert_array_equal, kept(tree), tree)

    def text(platform):
        return jax.jit(kept).trace(tree).lower(lowering_platforms=(platform,)).as_text()

    assert "optimization_barrier" in text("cuda")
    assert "optimization_barrier" not in text("cpu")
