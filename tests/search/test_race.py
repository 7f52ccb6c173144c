"""A race: deployments while a solution may still be better than the best."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from slcs2_jax.search import Race
from slcs2_jax.search.trial import WorldRace, raced

LIMITS = {"min_deployments": 1, "max_redeployments": 3}


@pytest.mark.parametrize(
    ("fitnesses", "count"),
    [
        ([0.2], 1),  # 0.2 + 0.2 <= 0.5
        ([0.4, 0.3], 2),  # 0.35 + 0.14 <= 0.5, and 0.4 + 0.2 is not
        ([0.4, 0.4], None),  # 0.4 + 0.14
        ([0.9, 0.9, 0.9], None),
        ([0.9, 0.9, 0.9, 0.9], 4),
        ([], None),
    ],
)
def test_it_goes_on_while_the_interval_reaches_above_the_rival(fitnesses, count):
    assert raced(fitnesses, rival=0.5, margin=0.2, **LIMITS) == count


def test_the_first_solution_is_deployed_as_often_as_any():
    assert raced([-1.0] * 3, rival=float("-inf"), margin=0.1, **LIMITS) is None
    assert raced([-1.0] * 4, rival=float("-inf"), margin=0.1, **LIMITS) == 4


def test_the_order_in_which_deployments_arrive_decides_nothing(make):
    fitnesses = [0.45, 0.2, 0.9, 0.9]
    for order in itertools.permutations(range(4)):
        race = Race(rival=0.5, margin=0.2, name="race", **LIMITS)
        for index in order:
            if not race.complete:
                race.add(index, make.deployment(fitnesses[index]))
        assert race.result().fitnesses == (0.45, 0.2)


def test_the_searchs_race_is_against_its_best_with_the_noise_measured(make):
    search = make.search(racing=True, race_width=2.0)
    assert search.trial(search.ask()[0]).wanted(9) == [0, 1, 2, 3, 4, 5]
    search.tell(search.ask(), [make.evaluation(0.5, (1, 0, 0), rules=8)])
    for fitness, done in ((0.5 - 2 * search.noise.deviation - 0.001, True), (0.5 - 2 * 0.15 + 0.001, False)):
        race = search.trial(search.ask()[0])
        race.add(0, make.deployment(fitness, (1, 0, 0), rules=8))
        assert race.complete is done


RIVAL = np.array([0.8, 0.4, -0.2, 0.6])


def through(make, fitnesses, *, rival=RIVAL, margin=0.2, kinds=2):
    trial = WorldRace(rival=rival, margin=margin, kinds=kinds, worlds=4, name="run")
    made = 0
    while not trial.complete:
        for index in trial.wanted():
            trial.add(index, make.deployment(fitnesses[index]))
            made += 1
    assert made == trial.result().deployments
    return trial.result()


def test_worlds_are_compared_one_by_one(make):
    poor = through(make, [0.6, 0.2])  # -0.2 and -0.2: -0.2 + 0.2 / sqrt(2) < 0
    assert poor.fitnesses == (0.6, 0.2)
    assert poor.fitness == pytest.approx(RIVAL.mean() - 0.2)  # as much worse in the rest
    lucky = through(make, [0.75, 0.38, -0.15, 0.55])  # hardly worse anywhere: to the end
    assert lucky.offset is None
    assert lucky.fitness == pytest.approx(np.mean([0.75, 0.38, -0.15, 0.55]))
    late = through(make, [0.8, 0.3, -0.6])
    assert late.deployments == 3
    assert late.fitness == pytest.approx(RIVAL.mean() - 0.5 / 3)


def test_each_kind_of_world_is_seen_and_without_a_rival_each_world(make):
    assert through(make, [-1.0, -1.0, -1.0, -1.0], kinds=3).deployments == 3
    assert through(make, [-1.0] * 4, rival=None).fitnesses == (-1.0,) * 4


def test_speculation_changes_nothing(make):
    fitnesses = [0.6, 0.2, 0.9, 0.9]
    trial = WorldRace(rival=RIVAL, margin=0.2, kinds=2, worlds=4, name="run")
    assert trial.wanted(0) == [0, 1]
    assert trial.wanted(9) == [0, 1, 2, 3]
    for index in (3, 1, 2, 0):
        trial.add(index, make.deployment(fitnesses[index]))
    assert trial.result().fitnesses == through(make, fitnesses).fitnesses
