"""The control without a search: two solutions by turns, the better of which wins by all of its deployments."""

from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.search import Starters, mean_of
from tests.search.test_informed import again, search_of, step, through_worlds

SETTINGS = {"name": "starters", "starts": 2, "final_deployments": 3, "episodes": 30, "generations": 500}


def test_both_are_deployed_equally_often_and_the_better_wins(make):
    search = search_of(make, kind=Starters, **SETTINGS)
    told = {0: [0.5, -0.5, 0.0, 0.0, 0.1], 1: [0.2, 0.2, 0.2, 0.2, 0.2]}
    for turn in range(5):
        for starter in (0, 1):
            [solution] = search.ask()
            assert solution.parent == (-1 if turn == 0 else starter)
            deployed = [make.deployment(told[starter][turn], (1, 0, 0, 0), rules=20) for _ in range(3)]
            search.tell([solution], [mean_of(deployed)])
        assert search.best.generation == (0 if turn == 0 else 1)  # luck lasts for a turn
    assert search.finished
    assert [member.evaluation.deployments for member in search.members] == [15, 15]
    assert search.best.fitness == pytest.approx(0.2)


def test_they_start_with_the_packet_rules_and_with_all(make):
    search = search_of(make, kind=Starters, **SETTINGS)
    one, other = search.ask(8)
    flags = [np.unique(solution.rules.reflex[:, :10].sum(axis=1)).tolist() for solution in (one, other)]
    assert flags == [[int(search.problem.knowledge.about_packets.sum())], [10]]


def test_many_worlds_are_gone_through_once_by_each_turn(make):
    search = through_worlds(make, kind=Starters, **SETTINGS)
    [solution] = search.ask()
    assert len(search.trial(solution).wanted()) == 6


@pytest.mark.parametrize("stop", [0, 1, 2, 5])
@pytest.mark.parametrize("batch", [1, 2])
def test_a_resumed_run_goes_on_exactly(make, stop, batch):
    search = search_of(make, kind=Starters, **SETTINGS)
    for _ in range(stop):
        step(search, batch)
    if not search.finished:
        search.ask(batch)
    resumed = again(search)
    while not search.finished:
        assert [repr(one) for one in step(resumed, batch)] == [repr(one) for one in step(search, batch)]
    assert resumed.best.fitness == search.best.fitness
    assert search.episodes == 30
