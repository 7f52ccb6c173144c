"""The fast path against the plain oracle: every step of episodes, and short episodes from end to end.

The oracle (float64, scalar) plays; each of its states is handed to the fast path (float32, batched), which makes the
same step. So a rounding that tips a comparison, which does happen once in thousands of steps, cannot hide what follows.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Container
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax import episode as episodes
from slcs2_jax.config import Settings, World
from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.grammar import load_grammar, random_rules
from slcs2_jax.policy import bits
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm import knowledge, links
from slcs2_jax.swarm.state import State
from slcs2_jax.world.arena import stack
from slcs2_jax.world.scenario import make_scenario
from tests.oracle import compiled
from tests.oracle.inputs import make_params, make_rules, make_world
from tests.oracle.memory import set_history
from tests.oracle.model import new_state, new_work

ENVIRONMENTS = ("open", "jammed", "urban", "urban_jammed")
GRAMMARS = ("main", "channel", "power", "both")
RULES = 100
CAPACITY = (96, 96)
CHANNELS = 3
WIDTH = 500  # steps compared at once: one batch width, one compiled program

CELLS = [
    (environment, grammar, "long" if place % 3 == 2 else "short")
    for place, (environment, grammar) in enumerate((e, g) for e in ENVIRONMENTS for g in GRAMMARS)
]


def make_case(environment: str, grammar_name: str, range_: str, seed: int) -> SimpleNamespace:
    """A scenario, random rules and a key, in the forms that both sides take."""
    settings = Settings(world=World.preset(environment, range_))
    scenario = make_scenario(settings, seed)
    while max(len(scenario.vertical), len(scenario.horizontal)) > CAPACITY[0]:
        seed += 100
        scenario = make_scenario(settings, seed)
    grammar = load_grammar(grammar_name)
    n = settings.swarm.agents
    rng = np.random.default_rng(seed)
    mask, action = random_rules(grammar, n * RULES, rng)
    mask, action = mask.reshape(n, RULES, 4), action.reshape(n, RULES)
    return SimpleNamespace(
        settings=settings,
        scenario=scenario,
        channels=grammar.channels_used,
        mask=mask,
        action=action,
        key=rng.integers(0, 2**32, 2, dtype=np.uint32),
        parameters=Parameters.of(settings),
        world=make_world(
            start=scenario.start,
            sink=scenario.sink,
            sink_estimate=scenario.sink_estimate,
            jammer=scenario.jammer,
            vertical=scenario.vertical,
            horizontal=scenario.horizontal,
            time_limit=scenario.time_limit,
        ),
        rules=make_rules(mask, action, [c in grammar.channels_used for c in range(3)]),
        params=make_params(settings.radio, settings.swarm, settings.learning, settings.world.wall_thickness),
    )


def copy_state(state: tuple) -> tuple:
    return type(state)(*(np.copy(field) for field in state))


def play_oracle(case: SimpleNamespace, steps: int, keep: Container[int]) -> tuple[list, list, list]:
    """Let the oracle play; returns its states before and after the steps to keep, and the actions taken."""
    functions = compiled.library()
    state, work = new_state(case.world, case.rules, case.params), new_work(case.world, case.rules)
    key0, key1 = map(int, case.key)
    before, after, actions = [], [], []
    for t in range(steps):
        if functions.is_over(state, case.world, case.params, t):
            break
        kept = t in keep
        if kept:
            before.append(copy_state(state))
        functions.step(state, case.world, case.rules, case.params, key0, key1, t, work)
        if kept:
            after.append(copy_state(state))
            actions.append(work.action.copy())
    return before, after, actions


def to_batch(case: SimpleNamespace, states: list, times: list[int]) -> Episode:
    """The oracle's states as one batch of the fast path."""
    count = len(states)

    def last(field: str, dtype: type = np.float32) -> np.ndarray:
        """[B, ...] with the agent axis first -> the batch last."""
        return np.moveaxis(np.stack([getattr(s, field) for s in states]), 0, -1).astype(dtype)

    place = last("place")
    known_place = last("known_place")  # [self, other, 2, B]
    history = last("history", np.uint32)  # [self, holder, B]
    n = history.shape[0]
    words = (history << np.arange(n, dtype=np.uint32)[None, :, None]).sum(axis=1, dtype=np.uint32)[None]
    depot = last("depot", np.int32)
    arena = jax.tree.map(
        jnp.asarray, stack([case.scenario] * count, [case.channels] * count, capacity=CAPACITY, width=CHANNELS)
    )
    rules = Rules(
        mask=jnp.asarray(np.repeat(case.mask.transpose(2, 1, 0)[..., None], count, axis=-1)),
        action=jnp.asarray(np.repeat(case.action.T[..., None], count, axis=-1)),
    )
    key = jnp.asarray(np.repeat(case.key[:, None], count, axis=1))
    fresh = episodes.begin(arena, rules, key, case.parameters)
    trace = np.stack([set_history(s, t).T for s, t in zip(states, times, strict=True)], axis=-1)
    state = dataclasses.replace(
        fresh.state,
        t=jnp.asarray(times, jnp.int32),
        node_x=jnp.asarray(place[:, 0]),
        node_y=jnp.asarray(place[:, 1]),
        known_time=jnp.asarray(last("known_time", np.int32).swapaxes(0, 1)),
        known_x=jnp.asarray(known_place[:, :, 0].swapaxes(0, 1)),
        known_y=jnp.asarray(known_place[:, :, 1].swapaxes(0, 1)),
        jammer_range=jnp.asarray(last("jammer_range")),
        holding=jnp.asarray(last("holding", bool)),
        history=jnp.asarray(words),
        waiting=jnp.asarray(depot[0]),
        delivered=jnp.asarray(depot[1]),
        contribution=jnp.asarray(last("contribution", np.int32)),
        interference=jnp.asarray(last("interference").swapaxes(0, 1)),
    )
    if case.scenario.jammer is None:  # the oracle parks an absent jammer elsewhere
        state = dataclasses.replace(
            state,
            node_x=state.node_x.at[-1].set(fresh.state.node_x[-1]),
            node_y=state.node_y.at[-1].set(fresh.state.node_y[-1]),
        )
    memory = dataclasses.replace(
        fresh.memory,
        quality=jnp.asarray(last("quality").swapaxes(0, 1)),
        error=jnp.asarray(last("error").swapaxes(0, 1)),
        members=bits.pack(jnp.asarray(trace & 1 == 1)),
        reward=jnp.asarray(last("reward")),
    )
    episode = dataclasses.replace(fresh, state=state, memory=memory)
    power = links.draw(state, arena, case.parameters.physics.radio)
    return dataclasses.replace(episode, state=dataclasses.replace(state, power=power))


@jax.jit
def fast_step(episode: Episode, parameters: Parameters) -> tuple[State, object, tuple[jax.Array, jax.Array]]:
    """One step, and sharing where it is due."""
    stepped, moment = episodes.step(episode, parameters)
    shared = knowledge.share(stepped.state)
    due = stepped.state.t % parameters.sharing_period == 0
    state = jax.tree.map(lambda a, b: jnp.where(due, a, b), shared, stepped.state)
    return state, stepped.memory, (moment.outcome.intent.acts, moment.reward)


def assert_close(
    name: str, found: np.ndarray, expected: np.ndarray, agree: np.ndarray, atol: float, rtol: float
) -> None:
    """Numbers [..., B] are close in the steps whose decisions agree, but for rounding that tipped something else."""
    wrong = ~np.isclose(found, expected, atol=atol, rtol=rtol)
    share = wrong.reshape(-1, wrong.shape[-1]).any(axis=0)[agree].mean()
    assert share <= 0.01, f"{name}: {share:.2%} of steps differ"


@pytest.mark.parametrize(("environment", "grammar", "range_"), CELLS, ids=["-".join(cell) for cell in CELLS])
def test_every_step_of_an_episode_is_the_oracles(environment: str, grammar: str, range_: str) -> None:
    case = make_case(environment, grammar, range_, seed=CELLS.index((environment, grammar, range_)))
    before, after, actions = play_oracle(case, WIDTH, range(WIDTH))
    compare_steps(case, before, after, actions, list(range(WIDTH)))


@pytest.mark.slow
@pytest.mark.parametrize("environment", ENVIRONMENTS)
@pytest.mark.parametrize("grammar", ["main", "both"])
def test_steps_all_along_a_whole_episode_are_the_oracles(environment: str, grammar: str) -> None:
    case = make_case(environment, grammar, "short", seed=50)
    kept = [t for t in range(20_000) if t % 1000 < 100]
    before, after, actions = play_oracle(case, 20_000, set(kept))
    assert len(before) >= WIDTH
    for low in range(0, len(before) // WIDTH * WIDTH, WIDTH):
        rows = slice(low, low + WIDTH)
        compare_steps(case, before[rows], after[rows], actions[rows], kept[rows])


def compare_steps(case: SimpleNamespace, before: list, after: list, actions: list, times: list[int]) -> None:
    """One fast step from each state before must give the state after."""
    count = len(before)
    batch = to_batch(case, before, times)
    state, memory, (acted, reward) = jax.device_get(fast_step(batch, case.parameters))
    expected = jax.device_get(to_batch(case, after, [t + 1 for t in times]))
    want, learnt = expected.state, expected.memory

    exact = [
        (state.holding, want.holding),
        (state.waiting[None], want.waiting[None]),
        (state.delivered[None], want.delivered[None]),
        (state.contribution, want.contribution),
        (state.history[0], want.history[0]),
        (memory.members, learnt.members),
        (state.known_time.reshape(-1, count), want.known_time.reshape(-1, count)),
    ]
    np.testing.assert_array_equal(state.t, want.t)
    agree = np.ones(count, bool)
    for a, b in exact:
        agree &= (a == b).reshape(-1, count).all(axis=0)
    assert agree.mean() >= 0.99, f"only {agree.mean():.2%} of steps have the same outcome"

    np.testing.assert_array_equal(acted[:, agree], (np.stack(actions, axis=-1) != 255)[:, agree])
    assert_close("x", state.node_x[:-3], want.node_x[:-3], agree, 2e-3, 0)
    assert_close("y", state.node_y[:-3], want.node_y[:-3], agree, 2e-3, 0)
    assert_close("known x", state.known_x, want.known_x, agree, 2e-3, 0)
    assert_close("known y", state.known_y, want.known_y, agree, 2e-3, 0)
    assert_close("jammer range", state.jammer_range, want.jammer_range, agree, 2e-3, 0)
    used = list(case.channels)
    assert_close("interference", state.interference[used], want.interference[used], agree, 0, 2e-3)
    assert_close("quality", memory.quality, learnt.quality, agree, 2e-3, 1e-3)
    assert_close("error", memory.error, learnt.error, agree, 2e-3, 1e-3)
    assert_close("reward", np.where(acted, reward, 0), np.where(acted, learnt.reward, 0), agree, 2e-3, 1e-3)


@pytest.mark.parametrize(("environment", "grammar"), [("open", "main"), ("urban_jammed", "both")])
def test_short_episodes_end_as_the_oracles(environment: str, grammar: str) -> None:
    """From deployment to the figures of the evaluation, without help; rounding may lead some astray."""
    limit, count = 120, 16
    cases = []
    for seed in range(count):
        case = make_case(environment, grammar, "short", seed)
        case.scenario = dataclasses.replace(case.scenario, time_limit=limit)
        case.world = case.world._replace(time_limit=limit)
        cases.append(case)
    arena = jax.tree.map(
        jnp.asarray,
        stack([c.scenario for c in cases], [c.channels for c in cases], capacity=CAPACITY, width=CHANNELS),
    )
    rules = Rules(
        mask=jnp.asarray(np.stack([c.mask.transpose(2, 1, 0) for c in cases], axis=-1)),
        action=jnp.asarray(np.stack([c.action.T for c in cases], axis=-1)),
    )
    key = jnp.asarray(np.stack([c.key for c in cases], axis=-1))
    parameters = cases[0].parameters

    @jax.jit
    def play(arena: object, rules: Rules, key: jax.Array, parameters: Parameters) -> object:
        episode = episodes.advance(episodes.begin(arena, rules, key, parameters), parameters, limit // 10 + 1)  # type: ignore[arg-type]
        return episodes.result(episode, parameters)

    result = jax.device_get(play(arena, rules, key, parameters))
    same = 0
    for b, case in enumerate(cases):
        outcome = compiled.run_episode(case.world, case.rules, case.params, *map(int, case.key))
        assert result.steps[b] == outcome.steps == limit
        if not np.array_equal(result.figures.usage[..., b].T, outcome.usage):
            continue
        same += 1
        assert result.delivered[b] == outcome.delivered
        np.testing.assert_array_equal(result.contribution[:, b], outcome.contribution)
        np.testing.assert_allclose(result.figures.quality[..., b].T, outcome.quality, atol=5e-3)
        np.testing.assert_allclose(result.figures.error[..., b].T, outcome.error, atol=5e-3)
        np.testing.assert_allclose(result.figures.strength[..., b].T, outcome.strength, atol=5e-3)
    assert same >= count / 2
