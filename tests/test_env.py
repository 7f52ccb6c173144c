"""The environment: an episode to step from outside has the bits of one that is computed in bulk."""

from __future__ import annotations

import dataclasses
import functools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import InputError, Radio, Settings, Swarm, World
from slcs2_jax.env import CELLS, AutoReset, Env, make
from slcs2_jax.grammar import random_rule_sets
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.looking.recorder import record
from slcs2_jax.looking.recording import Recording
from slcs2_jax.policy.bound import bind_list, bind_rules
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.search.keys import fresh_deployment_key
from slcs2_jax.swarm.state import SwarmParameters
from slcs2_jax.world.radio import RadioParameters
from slcs2_jax.world.scenario import Scenario, make_scenario

SMALL = {"swarm.agents": 4, "swarm.packets": 4, "rules.rules": 20, "compute.native": "off"}  # XLA, as the environment
NEAR = {"radio.power_dbm": 6.5, "world.distance": 110.0, "world.time_limit": 300, "grammar": "both"}  # net is 54 m
SEED = 7
PLACES = ("x", "y", "holding", "waiting", "delivered")


@functools.cache
def environment(world: str) -> Env:
    """Four agents, four packets: the open world, or a short urban one with a jammer and all channels and powers."""
    return (
        make("open_short", SMALL, seed=SEED) if world == "open" else make("urban_jammed_short", SMALL | NEAR, seed=SEED)
    )


@functools.cache
def recording(world: str) -> tuple[np.ndarray, np.ndarray, Recording]:
    """The designed behaviour in the open world, a random rule-set in the other: key, actions of the environment."""
    env = environment(world)
    if world == "open":
        deployed = bind_list(load_decision_list("designed"), env.agents)
    else:
        rules = random_rule_sets(env._grammar, env.agents, 20, np.random.default_rng(4))
        deployed = bind_rules(rules, env._grammar)
    key = fresh_deployment_key(SEED, 1)
    found = record(env.settings, make_scenario(env.settings, SEED), deployed, key)
    place = {number: index for index, number in enumerate((*env._grammar.actions, NO_ACTION))}
    return np.array(key, np.uint32), np.vectorize(place.get)(found.action).astype(np.int32), found


def play(env, key, actions, params):
    """A whole episode: the last state, and of every step the state after it, reward, terminated and truncated."""

    def one(state, action):
        _, state, *told, _ = env.step(key, state, action, params)
        return state, ({name: getattr(state.swarm, name) for name in PLACES}, *told)

    return jax.lax.scan(one, env.reset(key, params)[1], actions)


@functools.cache
def compiled(world: str, name: str):
    """A function of the environment, compiled once for this file."""
    return jax.jit(getattr(environment(world), name))


@functools.cache
def played(world: str):
    key, actions, _ = recording(world)
    return jax.jit(functools.partial(play, environment(world)))(key, actions, environment(world).params)


def assert_equal_trees(one, other):
    jax.tree.map(np.testing.assert_array_equal, one, other)


everywhere = pytest.mark.parametrize("world", ["open", "jammed"])


# The bits of an episode.


@everywhere
def test_an_episode_stepped_with_a_recordings_actions_is_the_recording(world):
    _, _, found = recording(world)
    last, (places, *_) = played(world)
    for name in PLACES:
        np.testing.assert_array_equal(places[name], getattr(found, name)[1:], name)
    np.testing.assert_array_equal(last.swarm.contribution, found.contribution)
    assert found.holding.any()
    assert (found.delivered[-1] == 4) == (world == "open")


def test_under_vmap_over_keys_each_episode_is_its_own():
    env = environment("jammed")
    key, actions, found = recording("jammed")
    keys = np.stack([key + np.uint32(1), key, key + np.uint32(2)])
    over_keys = jax.jit(jax.vmap(functools.partial(play, env), (0, None, None)))
    _, (places, *_) = over_keys(keys, actions, env.params)
    for name in PLACES:
        np.testing.assert_array_equal(places[name][1], getattr(found, name)[1:], name)
    assert (places["x"][0] != places["x"][2]).any()


def test_one_step_at_a_time_they_are_the_same():
    env = environment("jammed")
    key, actions, found = recording("jammed")
    _, state = compiled("jammed", "reset")(key, env.params)
    for t, action in enumerate(actions):
        _, state, *_ = compiled("jammed", "step")(None, state, action, env.params)
        for name in PLACES:
            np.testing.assert_array_equal(getattr(state.swarm, name), getattr(found, name)[t + 1], name)


def test_a_jax_key_is_as_good_as_its_words():
    env = environment("open")
    key = jax.random.key(3)
    assert_equal_trees(
        compiled("open", "reset")(key, env.params), compiled("open", "reset")(jax.random.key_data(key), env.params)
    )


# The end of an episode.


@everywhere
def test_terminated_and_truncated_are_told_apart(world):
    _, (_, _, terminated, truncated) = played(world)
    ended, other = (terminated, truncated) if world == "open" else (truncated, terminated)
    assert ended[-1]
    assert not ended[:-1].any()
    assert not other.any()


@everywhere
def test_an_episode_that_is_over_stands_still_without_reward(world):
    env = environment(world)
    last, (_, reward, *_) = played(world)
    assert np.asarray(reward).any()
    action = np.zeros(env.agents, np.int32)
    _, following, reward, terminated, truncated, info = compiled(world, "step")(None, last, action, env.params)
    assert_equal_trees(following, last)
    assert not reward.any()
    assert (bool(terminated), bool(truncated)) == (world == "open", world == "jammed")
    assert info["steps"] == recording(world)[2].steps


def test_an_automatic_reset_deploys_anew_and_keeps_the_last_observation():
    env = environment("jammed")
    key, actions, _ = recording("jammed")
    short = dataclasses.replace(env.params, arena=dataclasses.replace(env.params.arena, time_limit=jnp.int32(2)))
    auto = AutoReset(env)
    assert auto.spaces == env.spaces
    step, plain = jax.jit(auto.step), compiled("jammed", "step")
    start, state = compiled("jammed", "reset")(key, short)
    first = step(key, state, actions[0], short)
    assert_equal_trees(first[:5], plain(key, state, actions[0], short)[:5])
    again = key + np.uint32(1)
    seen, state, reward, terminated, truncated, info = step(again, first[1], actions[1], short)
    last = plain(again, first[1], actions[1], short)
    assert_equal_trees((info["last"], reward, terminated, truncated), (last[0], *last[2:5]))
    assert truncated
    assert info["steps"] == 2
    assert_equal_trees((seen, state), compiled("jammed", "reset")(again, short))
    assert not np.array_equal(seen.features, start.features)  # another key, other links


# Sharing.


def by_hand(start, *, sink=(600.0, 0.0), walls=(), thickness=1.0) -> Scenario:
    rows = np.asarray(walls, np.float32).reshape(-1, 3)
    return Scenario(
        environment="by hand",
        seed=0,
        sink=np.array(sink, np.float32),
        sink_estimate=np.array(sink, np.float32),
        jammers=(),
        vertical=rows,
        horizontal=np.zeros((0, 3), np.float32),
        wall_thickness=thickness,
        start=np.array(start, np.float32),
        time_limit=100,
    )


def test_knowledge_is_shared_at_the_end_of_every_sharing_period():
    settings = Settings(swarm=Swarm(agents=3, sharing_period=10))
    settings = dataclasses.replace(settings, radio=dataclasses.replace(settings.radio, shadowing_db=0.0))
    reach = settings.radio.network_range
    env = Env(settings, by_hand([(0.0, 5.0), (0.8 * reach, 5.0), (1.6 * reach, 5.0)]))
    _, state = jax.jit(env.reset)(jax.random.key(0), env.params)
    step = jax.jit(env.step)
    nothing = np.full(3, env.spaces.actions - 1, np.int32)
    knows = []
    for _ in range(10):
        _, state, *_ = step(None, state, nothing, env.params)
        known = np.asarray(state.swarm.known_time)
        knows.append((known[1, 0] >= 0, known[2, 0] >= 0))
    assert knows == [(True, False)] * 9 + [(True, True)]  # the third agent is out of reach, and heard of


# Worlds and physics that are swapped in.


def urban(seed: int) -> Scenario:
    return make_scenario(environment("jammed").settings, seed)


def test_stacked_worlds_are_stepped_as_each_alone():
    settings = environment("jammed").settings
    env = Env(settings, urban(0), walls=(80, 80))
    worlds = [env.arena(urban(seed)) for seed in range(3)]
    stacked = dataclasses.replace(env.params, arena=jax.tree.map(lambda *leaves: jnp.stack(leaves), *worlds))
    axes = dataclasses.replace(env.params, arena=0, physics=None)
    key, actions, _ = recording("jammed")
    episode = functools.partial(play, env)
    together = jax.jit(jax.vmap(episode, (None, None, axes)))(key, actions[:60], stacked)
    alone = jax.jit(episode)
    for number, arena in enumerate(worlds):
        one = alone(key, actions[:60], dataclasses.replace(env.params, arena=arena))
        assert_equal_trees(one[1][0], jax.tree.map(lambda leaf, number=number: leaf[number], together[1][0]))
    assert alone._cache_size() == 1
    assert len({np.asarray(world).tobytes() for world in together[1][0]["x"]}) == 3


BODY = ("packets", "speed", "clearance", "lidar_range", "distance_threshold", "tolerance")
PHYSICAL = [
    *(f"radio.{name}" for name, said in vars(Radio()).items() if isinstance(said, int | float)),
    *(f"swarm.{name}" for name in BODY),
    "learning.cost_move",
    "learning.cost_communicate",
]


def value(env: Env, name: str) -> float:
    section, _, last = name.partition(".")
    return getattr(getattr(env.settings, section), last)


def test_one_program_serves_every_value_of_every_physical_parameter():
    env = environment("open")
    key, actions, _ = recording("open")
    traces = []

    @jax.jit
    def after(changes):
        traces.append(changes)
        params = env.change(env.params, changes)
        _, state = env.reset(key, params)
        _, state, *_ = env.step(None, state, actions[0], params)
        return params.physics, state

    plain = {name: np.float32(value(env, name)) for name in PHYSICAL}
    after(plain)
    for name in PHYSICAL:
        changed = plain | {name: np.float32(plain[name] * 1.01)}
        physics, _ = after(changed)
        exact = env.change(env.params, {name: type(value(env, name))(changed[name])}).physics
        jax.tree.map(functools.partial(np.testing.assert_allclose, rtol=2e-5), physics, exact)
    assert (len(traces), after._cache_size()) == (1, 1)


def test_a_parameter_is_mapped_over_and_the_network_range_follows():
    env = environment("open")
    exponents = jnp.array([2.2, 2.8, 3.4], jnp.float32)
    key, actions, found = recording("open")

    def reach(exponent):
        params = env.change(env.params, {"radio.path_loss_exponent": exponent})
        last, (places, *_) = play(env, key, actions[:40], params)
        return params.physics.radio.network_range, places["x"], last.swarm.heard.sum()

    ranges, x, heard = jax.jit(jax.vmap(reach))(exponents)
    expected = [
        dataclasses.replace(env.settings.radio, path_loss_exponent=float(exponent)).network_range
        for exponent in exponents
    ]
    np.testing.assert_allclose(ranges, expected, rtol=1e-5)
    np.testing.assert_allclose(x[1], found.x[1:41], rtol=1e-5)
    assert heard[0] > heard[1] > heard[2]


def test_numbers_give_the_bits_that_settings_give_and_are_checked_like_them():
    env = environment("open")
    same = env.change(env.params, {name: value(env, name) for name in PHYSICAL})
    assert_equal_trees(same.physics, env.params.physics)
    assert_equal_trees(same.physics.radio, RadioParameters.of(env.settings.radio))
    assert_equal_trees(same.physics.swarm, SwarmParameters.of(env.settings))
    for changes, told in (
        ({"radio.path_loss_exponent": -1.0}, "radio.path_loss_exponent=-1.0: accepted is "),
        ({"swarm.speed": "fast"}, "swarm.speed=fast: accepted is "),
        ({"swarm.agents": 8}, "change=swarm.agents: accepted is "),
        ({"learning.alpha": 0.1}, "change=learning.alpha: accepted is "),
        ({"speed": 0.1}, "change=speed: accepted is "),
        ({"radio": 0.1}, "change=radio: accepted is "),
        ({3: 0.1}, "change=3: accepted is "),
    ):
        with pytest.raises(InputError) as caught:
            env.change(env.params, changes)
        assert str(caught.value).startswith(told)
        assert "\n" not in str(caught.value)


# What is seen.


def random_states(env: Env, world: str, steps: int, every: int):
    """Some states of an episode under random actions that could have an effect, with what is seen in them."""
    reset, step = compiled(world, "reset"), compiled(world, "step")
    rng = np.random.default_rng(2)
    seen, state = reset(jax.random.key(1), env.params)
    for t in range(steps):
        mask = np.asarray(seen.action_mask)
        action = np.array([rng.choice(np.flatnonzero(row)) for row in mask], np.int32)
        seen, state, *_ = step(None, state, action, env.params)
        if t % every == 0:
            yield seen, state


def plain_features(env: Env, seen, state, me: int) -> dict[str, float]:
    """An agent's figures by their names, in plain Python and double precision."""
    swarm, arena = state.swarm, env.params.arena
    n, net = env.agents, env.settings.radio.network_range
    here = (float(swarm.x[me]), float(swarm.y[me]))
    sink, source = (float(arena.estimate_x), float(arena.estimate_y)), (0.0, 0.0)
    known = [j for j in range(n) if swarm.known_time[j, me] >= 0]
    places = [(float(swarm.known_x[j, me]), float(swarm.known_y[j, me])) for j in known] + [source, sink]

    def closest(goal):
        nearer = [place for place in places if goal is None or math.dist(place, goal) < math.dist(here, goal)]
        return min((math.dist(place, here) for place in nearer), default=math.inf)

    distances = {
        "d_so": closest(source),
        "d_si": closest(sink),
        "d_c": closest(None),
        "d_sink": math.dist(here, sink),
        "d_source": math.dist(here, source),
        "xi, range of the nearest known jammer": float(swarm.jammer_range[me]) or math.inf,
    }
    heard = np.asarray(swarm.heard)
    level = [10 * math.log10(float(swarm.interference[c, me])) for c in range(len(swarm.interference))]
    threshold = env.settings.radio.receive_threshold_dbm
    return {
        **{name: min(distance / net, 10.0) for name, distance in distances.items()},
        "packet held": float(swarm.holding[me]),
        "source or sink heard": float(heard[n, me] or heard[n + 1, me]),
        "jammer known": float(swarm.jammer_range[me] > 0),
        "agents heard": sum(bool(heard[j, me]) for j in range(n) if j != me) / (n - 1),
        **{f"NI on channel {c}": (dbm - threshold) / 30 for c, dbm in enumerate(level)},
        "time": int(swarm.t) / int(arena.time_limit),
        "x": here[0] / math.hypot(*sink),
        "y": here[1] / net,
    }


@everywhere
def test_every_feature_is_what_its_name_unit_and_scale_say(world):
    env = environment(world)
    names = [feature.name for feature in env.features]
    values = []
    for seen, state in random_states(env, world, 240, 8):
        assert seen.features.shape == (env.agents, len(names))
        for me in range(env.agents):
            plain = plain_features(env, seen, state, me)
            assert list(plain) == names
            np.testing.assert_allclose(
                seen.features[me], list(plain.values()), rtol=2e-4, atol=2e-4, err_msg=str(list(plain))
            )
            values.append(list(plain.values()))
    varied = {name for name, column in zip(names, np.array(values).T, strict=True) if len(set(column)) > 1}
    constant = {"xi, range of the nearest known jammer", "jammer known", "source or sink heard"}
    assert varied == set(names) - (constant if world == "open" else set())


@everywhere
def test_an_action_that_is_masked_out_changes_nothing_but_costs_and_one_that_is_not_can(world):
    env = environment(world)
    nothing = env.spaces.actions - 1
    agents, actions = (side.ravel() for side in np.indices((env.agents, env.spaces.actions)))
    each = np.full((len(agents), env.agents), nothing, np.int32)
    each[np.arange(len(agents)), agents] = actions
    step = jax.jit(jax.vmap(env.step, (None, None, 0, None)))
    effective = np.zeros(env.spaces.actions, bool)
    for seen, state in random_states(env, world, 240, 16):
        _, after, reward, *_ = step(None, state, each, env.params)
        idle = np.flatnonzero(actions == nothing)[0]
        leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(after.swarm)]
        same = np.all([(leaf == leaf[idle]).reshape(len(each), -1).all(axis=1) for leaf in leaves], axis=0)
        allowed = np.asarray(seen.action_mask)[agents, actions]
        assert same[~allowed].all()
        gained = np.asarray(reward)[np.arange(len(agents)), agents]
        costs = [value(env, f"learning.cost_{kind}") for kind in ("move", "communicate")]
        assert np.isin(gained[~allowed], -np.array(costs, np.float32)).all()
        assert allowed[actions == nothing].all()
        assert not gained[actions == nothing].any()
        effective[actions[allowed & ~same]] = True
    worth = [text for text, used in zip(env.actions, effective, strict=True) if used]
    for kind in ("toward", "away", "collect", "send"):
        assert any(kind in text for text in worth), f"no {kind} had an effect"
    assert not effective[nothing]


def test_what_is_seen_has_the_sizes_that_the_spaces_tell_and_the_words_say_which():
    env = environment("jammed")
    seen, state = compiled("jammed", "reset")(jax.random.key(0), env.params)
    spaces = env.spaces
    assert seen.clauses.shape == (spaces.agents, spaces.clauses) == (4, len(env.clauses))
    assert seen.features.shape == (spaces.agents, spaces.features)
    assert seen.action_mask.shape == (spaces.agents, spaces.actions) == (4, len(env.actions))
    held = env.clauses.index("packet held")
    assert not seen.clauses[:, held].any()
    assert seen.clauses[:, env.clauses.index("no packet held")].all()
    assert_equal_trees(seen, jax.jit(env.observe)(state, env.params))


def test_a_number_that_is_no_action_is_to_do_nothing():
    env = environment("open")
    _, state = compiled("open", "reset")(jax.random.key(0), env.params)
    step = compiled("open", "step")
    nothing = step(None, state, np.full(4, env.spaces.actions - 1, np.int32), env.params)
    assert_equal_trees(step(None, state, np.array([-1, 1000, -(2**31), 255], np.int32), env.params), nothing)


# Bad input.


STARTS = [(0.0, 5.0), (5.0, 0.0), (0.0, -5.0), (-5.0, 0.0)]


@pytest.mark.parametrize(
    ("name", "changes", "told"),
    [
        ("open", {}, "make=open: accepted is one of open_short, "),
        (3, {}, "make=3: accepted is one of open_short, "),
        ("open_short", {"swarm.agent": 3}, "swarm.agent: no such setting; did you mean "),
        ("open_short", {"swarm.agents": 0}, "swarm.agents=0: accepted is "),
        ("open_short", {"swarm": 3, "swarm.agents": 8}, "swarm=3: accepted is "),
        ("open_short", {"environment": "urban"}, "environment=urban: accepted is "),
        ("open_short", {"task.name": "herding"}, "task.name=herding: accepted is "),
        ("open_short", 3, "changes=int: accepted is a dict"),
        ("open_short", {"seed": -1}, "seed=-1: accepted is "),
    ],
)
def test_make_refuses_in_one_line(name, changes, told):
    with pytest.raises(InputError) as caught:
        make(name, changes)
    assert str(caught.value).startswith(told)
    assert "\n" not in str(caught.value)


def test_every_world_is_made_by_its_name():
    assert len(CELLS) == 8
    for name in CELLS:
        world = make(name, seed=2).settings.world
        assert f"{world.environment}_{world.range}" == name
        assert World.preset(world.environment, world.range) == world


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"scenario": by_hand(STARTS[:3])}, "scenario.start=float32 [3, 2]: accepted is a float32 array [4, 2] "),
        ({"scenario": by_hand(STARTS, thickness=2.0)}, "scenario.wall_thickness=2.0: accepted is 1 m"),
        ({"scenario": by_hand(STARTS, walls=[(9, 1, 2)] * 17), "walls": (16, 0)}, "walls=(16, 0): accepted is "),
        ({"scenario": "urban"}, "scenario=str: accepted is a Scenario"),
        ({"walls": (-1, 0)}, "walls=-1: accepted is "),
        ({"walls": 3}, "walls=3: accepted is "),
        ({"task": "delivery"}, "task=str: accepted is a Delivery"),
        ({"settings": "open"}, "settings=str: accepted is a Settings"),
    ],
)
def test_an_environment_refuses_what_does_not_fit_in_one_line(given, told):
    with pytest.raises(InputError) as caught:
        Env(**{"settings": environment("open").settings} | given)
    assert str(caught.value).startswith(told)
    assert "\n" not in str(caught.value)
