"""What run folders have to show, and episodes of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.looking.solutions import best_of, member_of, members_of, replay
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.results import read_run
from slcs2_jax.results.run_folder import CHECKPOINT
from slcs2_jax.running import driver


def same(one, other) -> None:
    assert (one.fitness, one.generation, one.instance_seed) == (other.fitness, other.generation, other.instance_seed)
    for name in ("quality", "strength", "error", "usage", "contribution", "origin_kind"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(one.rules.mask, other.rules.mask)


@pytest.mark.parametrize("instance", [0, 1])
def test_a_run_under_way_shows_what_it_will_have_when_it_ends_there(finished, under_way, instance):
    before, after = read_run(under_way), read_run(finished)
    same(best_of(before, instance), best_of(after, instance))
    members = members_of(after, instance)
    assert members
    for one, other in zip(members_of(before, instance), members, strict=True):
        same(one, other)
    same(member_of(before, instance, "0"), members[0])


def test_what_is_not_there_is_refused(finished, under_way):
    run = read_run(under_way)
    with pytest.raises(InputError, match="instance=2: accepted is"):
        best_of(run, 2)
    with pytest.raises(InputError, match="member=99: accepted is best, or a number from 0 to"):
        member_of(read_run(finished), 0, "99")
    with pytest.raises(InputError, match="member=worst"):
        member_of(run, 0, "worst")
    (under_way / CHECKPOINT).write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"checkpoint\.npz"):
        best_of(run, 0)
    (under_way / CHECKPOINT).unlink()
    with pytest.raises(InputError, match="nothing was saved yet of instance 1"):
        best_of(run, 1)
    assert members_of(run, 1) == []


def test_replays_are_the_fresh_deployments_of_the_winner(finished):
    run = read_run(finished)
    best = run.best(1)
    found = [replay(best, deployment=number).fitness for number in range(2)]
    assert np.mean(found) == pytest.approx(run.summary["instances"][1]["fresh_mean"], abs=1e-12)


def test_elsewhere_and_by_hand(finished):
    best = read_run(finished).best(0)
    assert replay(best, seed=5).scenario.seed == 5
    behaviour = load_decision_list("designed")
    found = replay(behaviour, best.settings, seed=5, deployment=1)
    settings = dataclasses.replace(best.settings, seed=5, instances=1)
    [summary] = driver.evaluate(settings, behaviour, deployments=2).scenarios
    first = replay(behaviour, best.settings, seed=5)
    assert (found.fitness + first.fitness) / 2 == pytest.approx(summary.fitness, abs=1e-12)


def test_a_replay_of_something_else_is_refused(finished):
    best = read_run(finished).best(0)
    more = dataclasses.replace(best.settings, swarm=dataclasses.replace(best.settings.swarm, agents=4))
    fewer = dataclasses.replace(best.settings, rules=dataclasses.replace(best.settings.rules, rules=11))
    for settings, says in ((more, "swarm.agents=4: accepted is 3"), (fewer, "rules.rules=11: accepted is 12")):
        for refused in (replay, lambda solution, settings: driver.evaluate(settings, solution)):
            with pytest.raises(InputError, match=says):
                refused(best, settings)
    with pytest.raises(InputError, match="solution=str: accepted is a SavedSolution"):
        replay("best")
