"""Whole episodes: what holds at every step of any of them, and that batches and vmap change nothing."""

from __future__ import annotations

import dataclasses

import chex
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax import episode as episodes
from slcs2_jax.config import Learning, Settings, Swarm, World
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar import load_grammar, random_rules
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm import knowledge
from slcs2_jax.world.arena import stack, wall_capacity
from slcs2_jax.world.scenario import make_scenario

ENVIRONMENTS = ("open", "jammed", "urban", "urban_jammed")
GRAMMARS = ("main", "power", "channel", "both")
CASES = [(kind, grammar) for kind in ENVIRONMENTS for grammar in GRAMMARS]
AGENTS, RULES, PERIODS, PACKETS = 6, 40, 40, 20
EARLY = 137  # steps after which the last case's time is up
ROUNDING = 1.2e-3  # m: a millimetre short of the clearance still meets it, and places are in single precision


def settings(kind):
    """A short way from source to sink, so that packets arrive within a few hundred steps."""
    world = dataclasses.replace(World.preset(kind), distance=340.0)
    return Settings(world=world, swarm=Swarm(agents=AGENTS, packets=PACKETS, sink_error=2.0))


@dataclasses.dataclass(frozen=True)
class Batch:
    """One episode per case, not begun."""

    scenarios: list
    given: tuple  # arena, rules, key
    parameters: Parameters


@pytest.fixture(scope="module")
def batch():
    rng = np.random.default_rng(0)
    grammars = {name: load_grammar(name) for name in GRAMMARS}
    scenarios = [make_scenario(settings(kind), seed) for seed, (kind, _) in enumerate(CASES)]
    scenarios[-1] = dataclasses.replace(scenarios[-1], time_limit=EARLY)
    channels = [grammars[name].channels_used for _, name in CASES]
    drawn = [random_rules(grammars[name], AGENTS * RULES, rng) for _, name in CASES]
    mask = np.stack([m.reshape(AGENTS, RULES, -1) for m, _ in drawn], -1).transpose(2, 1, 0, 3)
    action = np.stack([a.reshape(AGENTS, RULES) for _, a in drawn], -1).transpose(1, 0, 2)
    arena = jax.tree.map(jnp.asarray, stack(scenarios, channels, capacity=wall_capacity(scenarios), width=3))
    key = jnp.asarray(rng.integers(0, 2**32, (2, len(CASES)), dtype=np.uint32))
    rules = Rules(jnp.asarray(mask), jnp.asarray(action))
    return Batch(scenarios, (arena, rules, key), Parameters.of(settings("open")))


def record(episode, moment):
    """What the invariants speak of, after one step."""
    state, memory = episode.state, episode.memory
    return {
        "t": state.t,
        "x": state.x,
        "y": state.y,
        "holding": state.holding,
        "waiting": state.waiting,
        "delivered": state.delivered,
        "contribution": state.contribution,
        "acts": moment.outcome.intent.acts,
        "reward": moment.reward,
        "quality": jnp.max(jnp.abs(memory.quality), axis=0),
        "error": jnp.max(jnp.abs(memory.error), axis=0),
        "interference": state.interference,
        "known_time": state.known_time,
        "jammer_range": state.jammer_range,
    }


def live(episode, parameters, periods):
    """``episode.advance`` from its parts, with a record of every step."""
    policy = parameters.policy

    def one_step(episode, _):
        episode, moment = episodes.step(episode, parameters)
        kept = policy.keep(episode.memory, moment.reward, moment.outcome.intent.acts)
        return episode, (record(episode, moment), kept)

    def one_period(episode, _):
        episode, (seen, kept) = jax.lax.scan(one_step, episode, length=parameters.sharing_period)
        memory = policy.settle(episode.memory, kept, parameters.learning)
        return dataclasses.replace(episode, memory=memory, state=knowledge.share(episode.state)), seen

    last, seen = jax.lax.scan(one_period, episode, length=periods)
    return last, jax.tree.map(lambda a: a.reshape(-1, *a.shape[2:]), seen)


QUICK = {"xla_backend_optimization_level": 0}  # for a few steps only: compiles in half the time
run = jax.jit(live, static_argnames="periods")
begin = jax.jit(episodes.begin)
result_of = jax.jit(episodes.result)
# Single instances, without a batch axis; one program for all of them, whatever the numbers.
advance = jax.jit(chex.assert_max_traces(episodes.advance, n=1), static_argnums=2)


@pytest.fixture(scope="module")
def track(batch):
    """The record of every step of the batch, [steps, ..., case]; the episodes afterwards, and halfway."""
    halfway, first = run(begin(*batch.given, batch.parameters), batch.parameters, periods=PERIODS // 2)
    last, second = run(halfway, batch.parameters, periods=PERIODS // 2)
    seen = jax.tree.map(lambda *parts: np.concatenate(parts), *jax.device_get((first, second)))
    return seen, last, halfway


def places(batch, track):
    """Tracks with the start: [steps + 1, agents, cases] twice, m."""
    arena = batch.given[0]
    return tuple(
        np.concatenate([np.asarray(start)[None], track[0][axis]]).astype(float)
        for axis, start in (("x", arena.start_x), ("y", arena.start_y))
    )


def test_enough_happens(track):
    """Otherwise the invariants would say little."""
    seen = track[0]
    assert seen["holding"].any(axis=(0, 1)).sum() > len(CASES) / 2
    assert seen["delivered"].max() > 0
    assert seen["acts"].mean() > 0.3
    assert (seen["jammer_range"] > 0).any()
    assert (seen["known_time"] >= 0).any()


def test_packets_are_conserved(track):
    seen = track[0]
    total = seen["waiting"] + seen["holding"].sum(axis=1) + seen["delivered"]
    np.testing.assert_array_equal(total, PACKETS)
    assert (seen["waiting"] >= 0).all()
    assert (np.diff(seen["delivered"], axis=0) >= 0).all()


def test_contributions_are_of_delivered_packets(track):
    contribution, delivered = track[0]["contribution"], track[0]["delivered"]
    assert (contribution <= delivered[:, None]).all()
    assert (contribution.sum(axis=1) >= delivered).all()
    assert (np.diff(contribution, axis=0) >= 0).all()


def test_time_passes_until_it_is_up(track):
    t = track[0]["t"]
    steps = np.arange(1, len(t) + 1)[:, None]
    limit = np.where(np.arange(len(CASES)) == len(CASES) - 1, EARLY, 20_000)
    over = (t >= limit) | (track[0]["delivered"] >= PACKETS)
    np.testing.assert_array_equal(t[~over], np.broadcast_to(steps, t.shape)[~over])
    assert t[-1, -1] == EARLY
    assert (np.diff(t, axis=0) <= 1).all()


def test_an_episode_that_is_over_stands_still(track):
    seen = track[0]
    assert not seen["acts"][EARLY:, :, -1].any()
    for name in ("x", "y", "holding", "waiting", "delivered", "contribution"):
        stays = seen[name][EARLY - 1 :, ..., -1]
        np.testing.assert_array_equal(stays, np.broadcast_to(stays[0], stays.shape))


def test_agents_keep_their_clearance(batch, track):
    x, y = places(batch, track)
    apart = np.hypot(x[:, :, None] - x[:, None], y[:, :, None] - y[:, None])
    others = ~np.eye(AGENTS, dtype=bool)
    assert apart[:, others].min() >= 2 - ROUNDING


def test_walls_are_kept_clear_of_and_never_crossed(batch, track):
    all_x, all_y = places(batch, track)
    for b, s in enumerate(batch.scenarios):
        x, y = all_x[..., b, None], all_y[..., b, None]
        for across, along, rows in ((x, y, s.vertical), (y, x, s.horizontal)):
            at, low, high = rows.T.astype(float)
            out = np.maximum(np.maximum(low - along, along - high), 0)
            clear = np.hypot(np.maximum(np.abs(across - at) - 0.5, 0), out)
            assert (clear >= np.minimum(2, clear[:1]) - ROUNDING).all()
            changes = (across[:-1] < at) != (across[1:] < at)
            rise = np.diff(along, axis=0) / np.where(changes, np.diff(across, axis=0), 1)
            height = along[:-1] + (at - across[:-1]) * rise
            assert not (changes & (height >= low) & (height <= high)).any()


def test_nobody_moves_farther_than_a_step(batch, track):
    x, y = places(batch, track)
    assert np.hypot(np.diff(x, axis=0), np.diff(y, axis=0)).max() <= 2 * (1 + 1e-5) + 1e-4


def test_everything_is_finite(track):
    for leaf in jax.tree.leaves(track[:2]):
        assert np.isfinite(np.asarray(leaf)).all()


def test_quality_and_error_are_bounded_by_the_rewards(track):
    seen = track[0]
    most = np.abs(np.where(seen["acts"], seen["reward"], 0)).max(axis=(0, 1))
    beta = Learning().beta_q
    assert (seen["quality"] <= most / (1 - beta) + 1e-4).all()
    assert (seen["error"] <= most * (1 + 1 / (1 - beta)) + 1e-4).all()


def test_knowledge_is_of_the_past_and_of_others(track):
    known, t = track[0]["known_time"], track[0]["t"]
    running = np.diff(t, axis=0, prepend=0) == 1
    assert (known < t[:, None, None]).transpose(1, 2, 0, 3)[:, :, running].all()
    assert (known[:, np.arange(AGENTS), np.arange(AGENTS)] == -1).all()
    assert (np.diff(known, axis=0) >= 0).all()


def test_jammers_are_known_where_there_are_any(track):
    there = np.array(["jammed" in kind for kind, _ in CASES])
    assert (track[0]["jammer_range"][..., ~there] == 0).all()
    assert (np.diff(track[0]["jammer_range"], axis=0) >= 0).all()


def test_usage_counts_the_steps_of_action_sets(batch, track):
    result = jax.device_get(result_of(track[1], batch.parameters))
    acted, figures = track[0]["acts"].sum(axis=0), result.figures
    assert (figures.usage.max(axis=0) <= acted).all()
    assert (figures.usage.sum(axis=0) >= acted).all()
    unused = figures.usage == 0
    assert (figures.strength[unused] == 0).all()
    assert (figures.quality[unused] == 0).all()
    assert (figures.error[unused] == 0).all()
    np.testing.assert_array_equal(result.steps, track[0]["t"][-1])
    np.testing.assert_array_equal(result.delivered, track[0]["delivered"][-1])


INTEGERS = ("t", "holding", "waiting", "delivered", "contribution", "acts", "known_time")


def same_story(one, other, where=""):
    for name in INTEGERS:
        np.testing.assert_array_equal(one[name], other[name], err_msg=f"{name} {where}")
    for name in ("x", "y"):
        np.testing.assert_allclose(one[name], other[name], atol=0.05, err_msg=f"{name} {where}")


STRETCH = 5  # periods that single instances advance at a time


def alone(given, b):
    """One episode of the batch, without the axis."""
    return jax.tree.map(lambda a: a[..., b], given)


@pytest.mark.parametrize("b", [3, 11, 14])
def test_a_single_instance_lives_as_it_does_in_a_batch(batch, track, b):
    """200 steps by ``advance`` and without any batch axis, against its parts, step by step, in a batch."""
    episode = begin(*alone(batch.given, b), batch.parameters)
    for stretch in range(1, PERIODS // 2 // STRETCH + 1):
        episode = advance(episode, batch.parameters, STRETCH)
        steps = stretch * STRETCH * batch.parameters.sharing_period
        for name in ("t", "holding", "waiting", "delivered", "contribution"):
            np.testing.assert_array_equal(getattr(episode.state, name), track[0][name][steps - 1, ..., b], err_msg=name)
        np.testing.assert_allclose(episode.state.x, track[0]["x"][steps - 1, ..., b], atol=0.05)
    together = alone(track[2], b)
    for name in ("known_time", "history", "heard"):
        np.testing.assert_array_equal(getattr(episode.state, name), getattr(together.state, name), err_msg=name)
    np.testing.assert_array_equal(episode.memory.usage, together.memory.usage)
    for name in ("quality", "error", "strength"):
        np.testing.assert_allclose(getattr(episode.memory, name), getattr(together.memory, name), atol=1e-2)


def test_other_numbers_need_no_other_program(batch):
    """Worlds, rules, keys and parameters are data; ``advance`` refuses a second trace."""
    learning = Learning(alpha_q=0.3, alpha_q_final=0.1, cost_move=0.4)
    swarm = Swarm(agents=AGENTS, packets=7, speed=1.0)
    parameters = Parameters.of(dataclasses.replace(settings("open"), learning=learning, swarm=swarm))
    for b in (0, 7):
        episode = advance(begin(*alone(batch.given, b), parameters), parameters, STRETCH)
        assert np.isfinite(episode.memory.quality).all()
        assert episode.memory.usage.any()


def test_the_order_of_the_batch_does_not_matter(batch, track):
    order = np.random.default_rng(1).permutation(len(CASES))
    mixed = jax.tree.map(lambda a: a[..., order], batch.given)
    _, seen = run(begin(*mixed, batch.parameters), batch.parameters, periods=PERIODS // 2)
    half = len(track[0]["t"]) // 2
    same_story(jax.device_get(seen), {name: leaf[:half, ..., order] for name, leaf in track[0].items()})


def test_vmap_over_the_last_axis_works(batch, track):
    few = jax.tree.map(lambda a: a[..., :5], batch.given)
    mapped = jax.vmap(lambda episode: episodes.step(episode, batch.parameters), in_axes=-1, out_axes=-1)
    step = jax.jit(mapped, compiler_options=QUICK)
    episode = begin(*few, batch.parameters)
    for t in range(batch.parameters.sharing_period):
        episode, moment = step(episode)
        seen = jax.device_get(record(episode, moment))
        same_story(seen, {name: leaf[t, ..., :5] for name, leaf in track[0].items()}, f"t={t}")


def test_an_episode_may_be_read_out_before_during_and_after(batch, track):
    begun = result_of(begin(*batch.given, batch.parameters), batch.parameters)
    assert not any(np.asarray(leaf).any() for leaf in jax.tree.leaves(begun))
    over = np.asarray(episodes.over(track[1], batch.parameters))
    assert over[-1]
    ended = (track[0]["delivered"][-1] >= PACKETS) | (np.arange(len(CASES)) == len(CASES) - 1)
    np.testing.assert_array_equal(over, ended)
    finished = alone(track[1], -1)
    later = advance(finished, batch.parameters, STRETCH)
    one, other = result_of(finished, batch.parameters), result_of(later, batch.parameters)
    for name in ("steps", "delivered", "contribution"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(one.figures.usage, other.figures.usage)
    for name in ("quality", "error", "strength"):
        np.testing.assert_allclose(getattr(one.figures, name), getattr(other.figures, name), atol=1e-5)
