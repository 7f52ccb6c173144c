"""Recordings: the same episodes as those that rollouts compute, told consistently."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from slcs2_jax import api
from slcs2_jax.config import Compute, Jammers, Radio, Rules, Settings, Swarm, World
from slcs2_jax.grammar import load_grammar, random_rule_sets
from slcs2_jax.grammar.vocabulary import NO_ACTION, PAPER
from slcs2_jax.looking.recorder import record
from slcs2_jax.looking.recording import NOBODY, Recording
from slcs2_jax.policy.bound import bind_list, bind_rules
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.search import fresh_deployment_key
from slcs2_jax.swarm.fate import Fate
from slcs2_jax.world.scenario import make_scenario

AGENTS, RULES = 4, 20
OPEN = Settings(
    world=World(distance=190.0, time_limit=1300),
    swarm=Swarm(agents=AGENTS, packets=4),
    rules=Rules(rules=RULES),
    compute=Compute(devices=1),
)
JAMMED = dataclasses.replace(
    OPEN,
    world=dataclasses.replace(World.preset("urban_jammed"), distance=110.0, time_limit=300),
    radio=Radio(power_dbm=6.5),  # net is 54 m
    rules=Rules(rules=RULES, grammar="both"),
)
TROUBLED = dataclasses.replace(
    JAMMED,
    swarm=dataclasses.replace(JAMMED.swarm, failure_rate=0.01, recovery_steps=20.0, failures_at=(50,)),
    radio=dataclasses.replace(JAMMED.radio, fading="rayleigh"),
    jammers=Jammers(count=3, emission="random", motion="pursue", power_db=-6.0),
)
WORLDS = {"open": OPEN, "jammed": JAMMED, "troubled": TROUBLED}
everywhere = pytest.mark.parametrize("world", ["open", "jammed"])


def deployed(world: str) -> tuple:
    settings = WORLDS[world]
    grammar = load_grammar(settings.rules.grammar)
    rules = random_rule_sets(grammar, AGENTS, RULES, np.random.default_rng(4))
    return settings, make_scenario(settings, 7), bind_rules(rules, grammar)


@functools.cache
def recording(world: str) -> Recording:
    settings, scenario, bound = deployed(world)
    return record(settings, scenario, bound, fresh_deployment_key(scenario.seed, 1))


@pytest.mark.parametrize("world", WORLDS)
def test_it_is_the_episode_that_a_rollout_computes(world):
    settings, scenario, bound = deployed(world)
    one, found = api.deploy(settings, scenario, bound.given, deployments=2)[1], recording(world)
    assert (found.steps, found.delivered[-1], found.fitness) == (one.steps, one.delivered, one.fitness)
    np.testing.assert_array_equal(found.contribution, one.contribution)
    for name in ("usage", "quality", "strength", "error"):
        np.testing.assert_array_equal(getattr(found, name), getattr(one.figures, name), name)


@everywhere
def test_the_rule_that_acted_held_and_says_what_was_done(world):
    found = recording(world)
    acted = found.rule != NOBODY
    np.testing.assert_array_equal(acted, found.action != NO_ACTION)
    agent = np.broadcast_to(np.arange(AGENTS), found.rule.shape)
    said = found.rules.action[agent[acted], found.rule[acted]]
    np.testing.assert_array_equal(said, found.action[acted])
    chosen = np.zeros((AGENTS, RULES), int)
    np.add.at(chosen, (agent[acted], found.rule[acted]), 1)
    assert (chosen <= found.usage).all()
    assert (found.usage <= found.matched).all()
    assert found.matched.max() <= found.steps
    assert acted.any()


@everywhere
def test_packets_move_where_transmissions_were_delivered(world):
    found = recording(world)
    held, waiting, delivered = found.holding.astype(int), found.waiting.astype(int), found.delivered.astype(int)
    assert (waiting + held.sum(axis=1) + delivered == found.settings.swarm.packets).all()
    moved = 0
    for step in range(found.steps):
        change = np.zeros(AGENTS + 2, int)
        for one in found.transmissions(step):
            if one.fate is Fate.DELIVERED:
                change[one.sender] -= 1
                change[one.receiver] += 1
                moved += 1
        np.testing.assert_array_equal(held[step + 1] - held[step], change[:AGENTS])
        assert waiting[step + 1] - waiting[step] == change[found.source]
        assert delivered[step + 1] - delivered[step] == change[found.sink]
    assert moved > 0


@everywhere
def test_transmissions_are_those_of_the_actions(world):
    found = recording(world)
    seen = set()
    for step in range(found.steps):
        for one in found.transmissions(step):
            seen.add(one.fate)
            kind = PAPER.actions[found.action[step, one.receiver if one.sender == found.source else one.sender]].kind
            assert kind == ("collect" if one.sender == found.source else "send")
            assert one.sender == found.source or found.holding[step, one.sender]
            assert found.neighbours(step)[one.receiver if one.sender < AGENTS else one.sender].any()
            assert one.fate is not Fate.JAMMED or found.jammed[step] == one.channel
    assert Fate.NONE not in seen
    assert len(seen) > 2


def test_steps_are_no_longer_than_the_speed_and_neighbours_hear_each_other():
    found = recording("open")
    length = np.hypot(np.diff(found.x, axis=0), np.diff(found.y, axis=0))
    assert length.max() <= found.settings.swarm.speed * 1.001
    assert length.max() > 0
    for step in range(0, found.steps, 50):
        among = found.neighbours(step)[:AGENTS]
        np.testing.assert_array_equal(among, among.T)  # links are reciprocal and nothing jams
        assert not among.diagonal().any()
    assert found.place(0, found.sink) == (190.0, 0.0)
    assert found.place(3, 2) == (found.x[3, 2], found.y[3, 2])


def test_the_jammer_is_seen_only_where_there_is_one():
    assert recording("open").jammed.shape == (recording("open").steps, 0)
    assert set(recording("jammed").jammed[:, 0].tolist()) <= {NOBODY, 0, 1, 2}
    assert (recording("jammed").jammed != NOBODY).any()


def test_a_list_made_by_hand_is_told_by_the_first_rule_that_holds():
    decisions = load_decision_list("designed")
    settings = dataclasses.replace(OPEN, rules=Rules(rules=len(decisions.rules)))
    scenario = make_scenario(settings, 3)
    key = fresh_deployment_key(3, 0)
    found = record(settings, scenario, bind_list(decisions, AGENTS), key)
    chosen = np.stack([np.bincount(rule[rule >= 0], minlength=len(decisions.rules)) for rule in found.rule.T])
    np.testing.assert_array_equal(chosen, found.usage)
    assert found.delivered[-1] == 4
