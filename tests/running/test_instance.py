"""What asks for deployments: scoring, a search from generation to generation, and the measurement of its winner."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from slcs2_jax.config import InputError, Settings, Swarm, World
from slcs2_jax.grammar import RuleSets
from slcs2_jax.policy.bound import BoundPolicy, bind_rules
from slcs2_jax.policy.policy import Figures
from slcs2_jax.rollout import Done, Job
from slcs2_jax.running.instance import Instance
from slcs2_jax.running.task import Measurement, Site
from slcs2_jax.search import Slcs2, deployment_key, fresh_deployment_key
from slcs2_jax.world.scenario import make_scenario

AGENTS, RULES, PACKETS, LIMIT, SEED = 3, 8, 10, 200, 7


@pytest.fixture
def site() -> Site:
    settings = Settings(world=World(time_limit=LIMIT), swarm=Swarm(agents=AGENTS, packets=PACKETS))
    return Site.of(make_scenario(settings, SEED), settings)


def ready(rules: RuleSets) -> BoundPolicy:
    return bind_rules(rules)


@pytest.fixture
def policy(make) -> BoundPolicy:
    return ready(make.solution(agents=AGENTS, rules=RULES).rules)


def done(job: Job, *, delivered: int = 0, steps: int = LIMIT, **arrays: np.ndarray) -> Done:
    """A finished deployment with the arrays given, zeros otherwise."""
    figures = {name: np.zeros((AGENTS, RULES), np.float32) for name in ("quality", "strength", "error")}
    figures["usage"] = np.ones((AGENTS, RULES), np.int32)
    contribution = arrays.pop("contribution", np.zeros(AGENTS, np.int32))
    learnt = Figures(**(figures | arrays))
    return Done(0, job, steps, delivered, contribution, learnt, measures={})


# -- Site --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("delivered", "steps", "fitness"),
    [(0, LIMIT, -1.0), (PACKETS, LIMIT, 0.0), (PACKETS, 50, 0.75), (5, LIMIT, -0.5), (PACKETS, 0, 1.0)],
)
def test_fitness_is_the_share_delivered_less_the_share_of_time(site, policy, delivered, steps, fitness):
    job = site.job(("search", 0, 0), policy, deployment_key(0, 0, 0))
    scored = site.score(done(job, delivered=delivered, steps=steps))
    assert scored.fitness == fitness
    assert (scored.delivered, scored.steps) == (delivered, steps)


def test_what_was_measured_is_handed_on(site, policy):
    rng = np.random.default_rng(0)
    arrays = {name: rng.normal(size=(AGENTS, RULES)).astype(np.float32) for name in ("quality", "strength", "error")}
    arrays["contribution"] = np.array([1, 2, 3], np.int32)
    job = site.job(("search", 0, 0), policy, deployment_key(0, 0, 0))
    scored = site.score(done(job, **arrays))
    for name, array in arrays.items():
        assert getattr(scored if name == "contribution" else scored.figures, name) is array


# -- Measurement -------------------------------------------------------------------------------------------------------


def test_a_measurement_wants_every_deployment_at_once_and_takes_them_in_any_order(site, policy):
    task = Measurement(site, policy, 4)
    assert task.wanted(0) == task.wanted(5) == [("fresh", 0, index) for index in range(4)]
    for index in (2, 0, 3):
        task.take(("fresh", 0, index), done(task.job(("fresh", 0, index)), delivered=index))
    assert task.wanted(0) == [("fresh", 0, 1)]
    assert not task.finished
    task.take(("fresh", 0, 1), done(task.job(("fresh", 0, 1)), delivered=1))
    assert task.finished
    assert task.wanted(8) == []
    assert [one.delivered for one in task.deployments] == [0, 1, 2, 3]


def test_fresh_deployments_have_keys_that_no_search_uses(site, policy):
    task = Measurement(site, policy, 3)
    keys = {task.job(name).key for name in task.wanted(0)}
    assert keys == {fresh_deployment_key(SEED, index) for index in range(3)}
    assert not keys & {deployment_key(SEED, generation, index) for generation in range(50) for index in range(6)}


@pytest.mark.parametrize("field", ["quality", "strength", "error"])
def test_nan_is_refused_by_name(site, policy, field):
    task = Measurement(site, policy, 1)
    broken = np.zeros((AGENTS, RULES), np.float32)
    broken[1, 2] = np.nan
    with pytest.raises(InputError, match=f"seed 7, fresh deployment 0: {field} of agent 1, rule 2 is nan"):
        task.take(("fresh", 0, 0), done(task.job(("fresh", 0, 0)), **{field: broken}))


# -- Instance ----------------------------------------------------------------------------------------------------------


class Play:
    """A run whose deployments come out as told."""

    def __init__(self, make, site: Site, *, generations: int = 3, fresh: int = 2, **settings) -> None:
        self.rows = []
        sizes = {"agents": AGENTS, "rules": RULES, "seed": SEED, "generations": generations}
        self.problem = make.problem(**sizes, fresh_deployments=fresh, **settings)
        self.make, self.site = make, site
        self.run = self.instance()

    def instance(self, kind=Slcs2) -> Instance:
        """One from its start."""
        return Instance(kind(self.problem), self.problem, self.site, ready, self.rows.append)

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
    [solution] = play.run.search.ask()
    job = play.run.job(("search", 0, 3))
    assert job.scenario is site.scenario
    assert job.key == deployment_key(SEED, 0, 3)
    np.testing.assert_array_equal(job.given.mask, solution.rules.mask)
    np.testing.assert_array_equal(job.given.action, solution.rules.action)
    play.fail()
    job = play.run.job(("search", 1, 0))
    assert job.key == deployment_key(SEED, 1, 0)
    np.testing.assert_array_equal(job.given.mask, play.run.search.ask()[0].rules.mask)


def test_the_winner_is_measured_once_the_search_is_over(make, site):
    play = Play(make, site, generations=3, fresh=2, max_redeployments=0)
    play.fail()
    [second] = play.run.search.ask()
    play.take(0, delivered=PACKETS, steps=100)
    assert play.run.measurement is None
    play.fail()
    run = play.run
    assert run.search.finished
    assert not run.finished
    assert run.winner.solution.equals(second)
    assert (run.winner.fitness, run.evaluations, run.env_steps) == (0.5, 3, 2 * LIMIT + 100)
    assert run.wanted(0) == [("fresh", 0, 0), ("fresh", 0, 1)]
    np.testing.assert_array_equal(run.job(("fresh", 0, 1)).given.mask, second.rules.mask)
    for index in range(2):
        play.take(index, delivered=PACKETS, steps=60)
    assert run.finished
    assert run.wanted(8) == []
    assert (run.evaluations, run.env_steps) == (3, 2 * LIMIT + 100), "fresh deployments are none of the search"
    assert run.useful_steps == run.env_steps + 120


def test_the_parents_fitness_is_expected(make, site):
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


# -- several solutions at once -----------------------------------------------------------------------------------------


def finish(instance: Instance, order: list[int] | None = None) -> None:
    """Take everything that is certain to count, last first or in the order given, until nothing is wanted."""
    while names := instance.wanted(0):
        for at in order or range(len(names))[::-1]:
            name = names[at % len(names)]
            if instance.wants(name):
                delivered = (name[1] * 7 + name[2]) % PACKETS
                instance.take(name, done(instance.job(name), delivered=delivered, steps=50 + name[1]))


def test_solutions_asked_for_together_are_deployed_side_by_side(make, site):
    play = Play(make, site, generations=6, batch=3)
    assert play.run.wanted(0) == [("search", generation, 0) for generation in range(3)]
    assert len(play.run.wanted(1)) == 6
    jobs = [play.run.job(("search", generation, 0)) for generation in range(3)]
    assert len({job.given.mask.tobytes() for job in jobs}) == 3
    assert [job.key for job in jobs] == [deployment_key(SEED, generation, 0) for generation in range(3)]
    for generation in (2, 0):
        play.run.take(("search", generation, 0), done(jobs[generation]))
    assert play.rows == [], "the search is told of all at once"
    assert not play.run.wants(("search", 2, 0))
    assert play.run.wants(("search", 1, 3))
    play.run.take(("search", 1, 0), done(jobs[1]))
    assert [row.generation for row in play.rows] == [0, 1, 2]
    assert play.run.wanted(0) == [("search", generation, 0) for generation in range(3, 6)]


def test_in_which_order_they_arrive_decides_nothing(make, site):
    rows = []
    for order in (None, [0], [1, 0, 2], [2, 1]):
        play = Play(make, site, generations=12, batch=3, fresh=1)
        finish(play.run, order)
        assert play.run.finished
        rows.append([dataclasses.astuple(row)[:8] for row in play.rows])
    assert rows[0] == rows[1] == rows[2] == rows[3]
    assert [row[5] for row in rows[0]] == list(np.maximum.accumulate([row[1] for row in rows[0]]))


def test_an_instance_goes_on_exactly_between_any_two_deployments(make, site):
    play = Play(make, site, generations=6, batch=3)
    finish(play.run)
    expected = [repr(row) for row in play.rows]
    play.rows.clear()
    instance = play.instance()
    while not instance.finished:
        name = instance.wanted(0)[-1]
        delivered = (name[1] * 7 + name[2]) % PACKETS
        instance.take(name, done(instance.job(name), delivered=delivered, steps=50 + name[1]))
        arrays, meta = instance.state()
        before, wanted = instance.progress, instance.wanted(0)
        instance = play.instance()
        instance.restore(arrays, json.loads(json.dumps(meta, allow_nan=False)))
        assert (instance.progress, instance.wanted(0)) == (before, wanted)
    assert [repr(row) for row in play.rows] == expected
    assert instance.evaluations == sum(row.deployments for row in play.rows)


class Wrong(Slcs2):
    """A plug-in that gives something else than it is asked for."""

    def __init__(self, problem, give, verdicts=None):
        super().__init__(problem)
        self.give, self.verdicts = give, verdicts

    def ask(self, count=1):
        return self.give(super().ask(count))

    def tell(self, solutions, evaluations):
        found = super().tell(solutions, evaluations)
        return found if self.verdicts is None else self.verdicts


@pytest.mark.parametrize(
    ("give", "says"),
    [
        (lambda asked: [], "accepted is a search that gives a solution until it is finished"),
        (lambda asked: ["rules"], "solution of generation 0 is a str; accepted is a Solution"),
        (lambda asked: [dataclasses.replace(asked[0], generation=3)], "says that it is that of 3"),
    ],
)
def test_a_search_that_gives_something_else_is_named(make, site, give, says):
    play = Play(make, site, name="random")
    with pytest.raises(InputError, match=rf"search=random.*{says}"):
        play.instance(lambda problem: Wrong(problem, give))


def test_sizes_and_verdicts_are_looked_at(make, site):
    play = Play(make, site, name="random")
    with pytest.raises(InputError, match=r"search=random: .* has \[2, 8\] agents and rules; accepted are \[3, 8\]"):
        play.instance(lambda problem: Wrong(problem, lambda asked: [make.solution(agents=2, rules=RULES)]))
    instance = play.instance(lambda problem: Wrong(problem, list, verdicts=[]))
    [name] = instance.wanted(0)
    with pytest.raises(InputError, match=r"search=random: tell\(\) returned 0 verdicts for 1 solutions"):
        instance.take(name, done(instance.job(name)))
