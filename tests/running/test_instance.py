"""What asks for deployments: scoring, a search from generation to generation, and the measurement of its winner."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config import InputError, Settings, Swarm, World
from slcs2_jax.grammar import RuleSets
from slcs2_jax.rollout import Done, Job
from slcs2_jax.running.instance import Instance, Measurement, Site
from slcs2_jax.search import deployment_key, fresh_deployment_key
from slcs2_jax.world.scenario import make_scenario

AGENTS, RULES, PACKETS, LIMIT, SEED = 3, 8, 10, 200, 7


@pytest.fixture
def site() -> Site:
    settings = Settings(world=World(time_limit=LIMIT), swarm=Swarm(agents=AGENTS, packets=PACKETS))
    return Site(make_scenario(settings, SEED), (0,), PACKETS)


@pytest.fixture
def rules(make) -> RuleSets:
    solution = make.solution(agents=AGENTS, rules=RULES)
    return RuleSets(solution.mask, solution.action)


def done(job: Job, *, delivered: int = 0, steps: int = LIMIT, **arrays: np.ndarray) -> Done:
    """A finished deployment with the arrays given, zeros otherwise."""
    reals = {name: np.zeros((AGENTS, RULES), np.float32) for name in ("quality", "strength", "error")}
    filled = reals | {"usage": np.ones((AGENTS, RULES), np.int32), "contribution": np.zeros(AGENTS, np.int32)} | arrays
    return Done(slot=0, job=job, steps=steps, delivered=delivered, **filled)


# -- Site --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("delivered", "steps", "fitness"),
    [(0, LIMIT, -1.0), (PACKETS, LIMIT, 0.0), (PACKETS, 50, 0.75), (5, LIMIT, -0.5), (PACKETS, 0, 1.0)],
)
def test_fitness_is_the_share_delivered_less_the_share_of_time(site, rules, delivered, steps, fitness):
    job = site.job(("search", 0, 0), rules, deployment_key(0, 0, 0))
    scored = site.score(done(job, delivered=delivered, steps=steps))
    assert scored.fitness == fitness
    assert (scored.delivered, scored.steps) == (delivered, steps)


def test_what_was_measured_is_handed_on(site, rules):
    rng = np.random.default_rng(0)
    arrays = {name: rng.normal(size=(AGENTS, RULES)).astype(np.float32) for name in ("quality", "strength", "error")}
    arrays["contribution"] = np.array([1, 2, 3], np.int32)
    job = site.job(("search", 0, 0), rules, deployment_key(0, 0, 0))
    scored = site.score(done(job, **arrays))
    for name, array in arrays.items():
        assert getattr(scored, name) is array


# -- Measurement -------------------------------------------------------------------------------------------------------


def test_a_measurement_wants_every_deployment_at_once_and_takes_them_in_any_order(site, rules):
    task = Measurement(site, rules, 4)
    assert task.wanted(0) == task.wanted(5) == [("fresh", 0, index) for index in range(4)]
    for index in (2, 0, 3):
        task.take(("fresh", 0, index), done(task.job(("fresh", 0, index)), delivered=index))
    assert task.wanted(0) == [("fresh", 0, 1)]
    assert not task.finished
    task.take(("fresh", 0, 1), done(task.job(("fresh", 0, 1)), delivered=1))
    assert task.finished
    assert task.wanted(8) == []
    assert [one.delivered for one in task.deployments] == [0, 1, 2, 3]


def test_fresh_deployments_have_keys_that_no_search_uses(site, rules):
    task = Measurement(site, rules, 3)
    keys = {task.job(name).key for name in task.wanted(0)}
    assert keys == {fresh_deployment_key(SEED, index) for index in range(3)}
    assert not keys & {deployment_key(SEED, generation, index) for generation in range(50) for index in range(6)}


@pytest.mark.parametrize("field", ["quality", "strength", "error"])
def test_nan_is_refused_by_name(site, rules, field):
    task = Measurement(site, rules, 1)
    broken = np.zeros((AGENTS, RULES), np.float32)
    broken[1, 2] = np.nan
    with pytest.raises(InputError, match=f"seed 7, fresh deployment 0: {field} of agent 1, rule 2 is nan"):
        task.take(("fresh", 0, 0), done(task.job(("fresh", 0, 0)), **{field: broken}))


# -- Instance ----------------------------------------------------------------------------------------------------------


class Play:
    """A run whose deployments come out as told."""

    def __init__(self, make, site: Site, *, generations: int = 3, fresh: int = 2, **settings) -> None:
        self.rows = []
        search = make.search(agents=AGENTS, rules=RULES, seed=SEED, generations=generations, **settings)
        self.run = Instance(search, site, fresh, self.rows.append)

    def take(self, index: int, **values) -> None:
        name = next(name for name in self.run.wanted(8) if name[2] == index)
        self.run.take(name, done(self.run.job(name), **values))

    def fail(self, times: int = 1) -> None:
        """Generations whose first deployment delivers nothing."""
        for _ in range(times):
            self.take(0)


def test_a_bad_solution_has_one_deployment(make, site):
    play = Play(make, site)
    assert play.run.wanted(0) == [("search", 0, 0)]
    play.fail()
    assert [(row.generation, row.fitness, row.deployments) for row in play.rows] == [(0, -1.0, 1)]
    assert play.run.wanted(0) == [("search", 1, 0)]
    assert (play.run.evaluations, play.run.env_steps) == (1, LIMIT)


def test_a_good_solution_is_deployed_again_up_to_five_times(make, site):
    play = Play(make, site)
    for index in range(6):
        assert play.run.wanted(0) == [("search", 0, index)]
        play.take(index, delivered=PACKETS, steps=100 + index)
    [row] = play.rows
    assert (row.deployments, row.steps, row.delivered) == (6, 102.5, PACKETS)
    assert row.fitness == pytest.approx(1 - 102.5 / LIMIT)
    assert (play.run.evaluations, play.run.env_steps) == (6, 615)


def test_speculative_deployments_count_only_if_they_would_have_been_made(make, site):
    play = Play(make, site)
    play.take(2, delivered=PACKETS, steps=20)  # ahead of its turn
    play.take(1, delivered=0)
    assert play.rows == []
    play.take(0, delivered=PACKETS, steps=150)
    # .25, then -1: the mean is below zero and the third does not count
    [row] = play.rows
    assert (row.deployments, row.fitness) == (2, pytest.approx(-0.375))
    assert (play.run.evaluations, play.run.env_steps) == (2, 150 + LIMIT)


def test_wanted_looks_ahead_within_one_generation_only(make, site):
    play = Play(make, site)
    assert play.run.wanted(2) == [("search", 0, index) for index in range(3)]
    assert play.run.wanted(8) == [("search", 0, index) for index in range(6)]
    play.take(1, delivered=PACKETS)
    assert play.run.wanted(2) == [("search", 0, index) for index in (0, 2)]


def test_jobs_are_the_solution_asked_for_under_the_keys_of_the_search(make, site):
    play = Play(make, site)
    solution = play.run.search.ask()
    job = play.run.job(("search", 0, 3))
    assert job.scenario is site.scenario
    assert job.key == deployment_key(SEED, 0, 3)
    np.testing.assert_array_equal(job.mask, solution.mask)
    np.testing.assert_array_equal(job.action, solution.action)
    play.fail()
    job = play.run.job(("search", 1, 0))
    assert job.key == deployment_key(SEED, 1, 0)
    np.testing.assert_array_equal(job.mask, play.run.search.ask().mask)


def test_the_winner_is_measured_once_the_search_is_over(make, site):
    play = Play(make, site, generations=3, fresh=2, max_redeployments=0)
    play.fail()
    second = play.run.search.ask()
    play.take(0, delivered=PACKETS, steps=100)
    assert play.run.measurement is None
    play.fail()
    run = play.run
    assert run.search.finished
    assert not run.finished
    assert run.winner.solution.equals(second)
    assert (run.winner.fitness, run.evaluations, run.env_steps) == (0.5, 3, 2 * LIMIT + 100)
    assert run.wanted(0) == [("fresh", 0, 0), ("fresh", 0, 1)]
    np.testing.assert_array_equal(run.job(("fresh", 0, 1)).mask, second.mask)
    for index in range(2):
        play.take(index, delivered=PACKETS, steps=60)
    assert run.finished
    assert run.wanted(8) == []
    assert (run.evaluations, run.env_steps) == (3, 2 * LIMIT + 100), "fresh deployments are none of the search"
    assert run.useful_steps == run.env_steps + 120


def test_hope_is_the_parents_fitness(make, site):
    play = Play(make, site, max_redeployments=0)
    assert play.run.expected_fitness == 0.0
    play.take(0, delivered=PACKETS, steps=100)
    assert play.run.expected_fitness == 0.5


def test_nan_is_refused_with_seed_generation_and_deployment(make, site):
    play = Play(make, site)
    play.fail()
    broken = np.full((AGENTS, RULES), np.inf, np.float32)
    with pytest.raises(InputError, match=r"run with seed 7, generation 1, deployment 0: quality of agent 0"):
        play.take(0, quality=broken)


def test_order_of_arrival_decides_nothing(make, site):
    steps = [40, 90, 10, 160, 30, 70]
    rows = []
    for order in ([0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [3, 0, 5, 1, 4, 2]):
        play = Play(make, site)
        for index in order:
            play.take(index, delivered=PACKETS, steps=steps[index], contribution=np.full(AGENTS, index, np.int32))
        rows.append(dataclasses.astuple(play.rows[0]))
    assert rows[0][1:6] == rows[1][1:6] == rows[2][1:6]
    assert rows[0][-1] == rows[1][-1] == rows[2][-1] == (2.5,) * AGENTS
