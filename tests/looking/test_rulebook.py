"""Rules in words: counts agree with the replay, origins and the spread by exchange with the solution."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import types

import numpy as np
import pytest

from slcs2_jax.config import Rules, Settings, Swarm
from slcs2_jax.grammar import RuleSets, load_grammar
from slcs2_jax.grammar.ruleset import parse_rule_text
from slcs2_jax.looking.rulebook import acting, chosen_counts, origin_text, rule_lines, spread_rules
from slcs2_jax.looking.rules_text import Rulebook
from slcs2_jax.results import SavedSolution

CARRY, FETCH, IDLE = (
    "packet held => move toward sink",
    "no packet held => move toward source",
    "d_si < net => send to si",
)


@pytest.fixture
def solution() -> SavedSolution:
    """Three agents; agent 1 has its first rule from agent 0, agent 2 the same from agent 1."""
    texts = [[CARRY, FETCH, CARRY], [CARRY, FETCH, IDLE], [CARRY, IDLE, IDLE]]
    rules = RuleSets.from_rules([[parse_rule_text(text) for text in agent] for agent in texts])
    strength = np.array([[0.1, 0.3, 0.2], [1, 2, 3], [0, 0, 0]], np.float32)
    return SavedSolution(
        rules=rules,
        quality=strength[::-1].copy(),
        strength=strength,
        error=np.zeros((3, 3), np.float32),
        usage=np.array([[5, 1, 9], [1, 1, 1], [0, 0, 0]], np.int32),
        contribution=np.array([3, 0, 1], np.float32),
        settings=Settings(swarm=Swarm(agents=3), rules=Rules(rules=3)),
        grammar_text=load_grammar("main").text,
        instance_seed=4,
        generation=7,
        fitness=0.25,
        deployments=2,
        origin_kind=np.array([[0, 0, 1], [2, 0, 0], [2, 0, 1]], np.uint8),
        origin_generation=np.array([[0, 0, 5], [6, 0, 0], [7, 0, 3]], np.int32),
        origin_agent=np.array([[-1, -1, -1], [0, -1, -1], [1, -1, -1]], np.int8),
    )


@pytest.fixture
def recording():
    """Four steps of three agents."""
    rule = np.array([[0, 1, -1], [2, 1, -1], [0, -1, -1], [0, 2, -1]], np.int16)
    matched = np.array([[4, 0, 4], [1, 3, 2], [0, 0, 0]], np.int32)
    return types.SimpleNamespace(rule=rule, matched=matched, fitness=0.5, steps=4)


def book(solution, recording=None) -> Rulebook:
    return Rulebook(
        solution=solution,
        lines=rule_lines(solution, recording),
        spread=spread_rules(solution),
        replay_fitness=None if recording is None else recording.fitness,
        steps=None if recording is None else recording.steps,
    )


def test_rules_are_counted_where_they_were_drawn(solution, recording):
    np.testing.assert_array_equal(chosen_counts(recording), [[3, 0, 1], [0, 2, 1], [0, 0, 0]])
    lines = {(line.agent, line.index): line for line in rule_lines(solution, recording)}
    assert (lines[0, 2].matched, lines[0, 2].chosen) == (4, 1)
    assert (lines[1, 1].matched, lines[1, 1].chosen) == (3, 2)
    assert rule_lines(solution)[0].matched is None


@pytest.mark.parametrize(("sort", "order"), [("strength", [1, 2, 0]), ("use", [2, 0, 1]), ("quality", [0, 1, 2])])
def test_the_greatest_comes_first_and_equals_keep_their_order(solution, sort, order):
    assert [line.index for line in rule_lines(solution, sort=sort)[:3]] == order


def test_equal_rules_of_an_agent_are_one_where_it_is_told_what_it_did(solution, recording):
    lines = rule_lines(solution, recording)
    assert [(line.rule, line.chosen) for line in acting(lines, 0)] == [(CARRY, 4)]
    assert [(line.rule, line.chosen) for line in acting(lines, 1)] == [(FETCH, 2), (IDLE, 1)]
    assert acting(lines, 2) == []


def test_origins_in_words(solution):
    assert origin_text(0, 0, -1) == "initial"
    found = {(line.agent, line.index): line.origin for line in rule_lines(solution)}
    assert found[0, 2] == "random in generation 5"
    assert found[2, 0] == "copied from agent 1 in generation 7"


def test_what_exchange_spread(solution):
    [one] = spread_rules(solution)
    assert one.rule == CARRY
    assert one.holders == (0, 1, 2)
    assert one.copies == ((6, 0, 1), (7, 1, 2))
    initial = dataclasses.replace(solution, origin_kind=None, origin_generation=None, origin_agent=None)
    assert spread_rules(initial) == []
    assert "no rule came from another agent" in book(initial).text(0)


def test_text_csv_and_json_say_the_same(solution, recording):
    one = book(solution, recording)
    rows = list(csv.DictReader(io.StringIO(one.csv())))
    document = json.loads(one.json())
    assert len(rows) == len(document["rules"]) == 9
    for row, rule in zip(rows, document["rules"], strict=True):
        assert {name: str(value) for name, value in rule.items()} == row
    assert document["spread"] == [{"rule": CARRY, "holders": [0, 1, 2], "copies": [[6, 0, 1], [7, 1, 2]]}]
    assert document["replay_fitness"] == 0.5
    text = one.text(2)
    assert "short open, seed 4" in text
    assert "... and 1 more" in text
    assert f"100.0%  {CARRY}" in text
    assert "more" not in one.text(0)
    assert "most often" not in book(solution).text(0)
