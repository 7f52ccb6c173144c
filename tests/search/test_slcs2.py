from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config import Search as SearchSettings
from slcs2_jax.search import Deployment, HistoryRow, Origin, Search, deployment_key, mean_of
from slcs2_jax.search.slcs2 import make_acceptance


def goodness(action: np.ndarray) -> np.ndarray:
    """How good a rule is in the toy world: 1 for the six lowest of 57 actions, 0 else."""
    return (action < 6).astype(np.float64)


def toy(solution, key=(0, 0)) -> Deployment:
    """A world whose fitness is the share of good rules: good ones are strong and foreseen without error.

    Differs a little by deployment key, so that resuming with other keys would show.
    """
    good = goodness(solution.action)
    noise = np.random.default_rng([int(word) for word in key]).normal(0, 0.01)
    return Deployment(
        fitness=float(2 * good.mean() - 1 + noise),
        delivered=int(good.sum()),
        steps=10,
        contribution=good.sum(axis=1).astype(np.int64),
        quality=good.astype(np.float32),
        strength=good.astype(np.float32),
        error=(1 - good).astype(np.float32),
        usage=np.ones(good.shape, np.int32),
    )


def step(search: Search) -> HistoryRow:
    solution, trial = search.ask(), search.trial()
    while not trial.complete:
        for index in trial.wanted():
            trial.add(index, toy(solution, search.deployment_key(index)))
    return search.tell(trial.result())


def plain(row: HistoryRow) -> dict:
    return {name: None if value != value else value for name, value in vars(row).items()}


@pytest.mark.parametrize("acceptance", ["domination", "ailta"])
def test_the_search_gets_further_than_random_solutions(make, acceptance):
    runs = [make.search(agents=4, rules=20, seed=seed, acceptance=acceptance, generations=120) for seed in range(3)]
    found = []
    for search in runs:
        while not search.finished:
            step(search)
        found.append(2 * goodness(search.best.solution.action).mean() - 1)
    rng = np.random.default_rng(0)
    chance = max(2 * goodness(make.source(80, rng)[1]).mean() - 1 for _ in range(3 * 120))
    assert min(found) > chance + 0.2


def test_rows_tell_what_happened(make):
    search = make.search(generations=60, agents=4, rules=20)
    best, families = -2.0, set()
    for generation in range(60):
        asked, held = search.ask(), {member.generation for member in search.members}
        row = step(search)
        now = {member.generation for member in search.members}
        assert row.generation == generation == asked.generation
        assert row.parent == asked.parent
        assert row.parent in held or (generation == 0 and row.parent == -1)
        assert row.accepted == (generation in now)
        assert row.size == len(now)
        assert row.removed == len(held - now)
        new = asked.origin_generation == generation
        assert row.copied == (new & (asked.origin_kind == Origin.COPIED)).sum()
        assert row.copied + row.fresh == new.sum()
        best = max(best, row.fitness)
        assert row.best == best == search.best.fitness
        assert row.best_generation == search.best.generation
        assert math.isnan(row.novelty) == (generation == 0)
        assert len(row.contribution) == 4
        families.add((row.parent, row.explorations))
    assert len(families) == 60  # every attempt of a parent has its own count
    assert search.finished
    with pytest.raises(InputError, match="all 60 generations are done"):
        search.ask()


def test_the_earliest_of_equals_is_the_best(make):
    search = make.search()
    for fitness in (-0.5, -0.2, -0.2, -0.9):
        search.ask()
        row = search.tell(make.evaluation(fitness, (0, 0, 0), rules=8))
    assert search.best.generation == row.best_generation == 1
    assert row.best == -0.2


def test_asking_twice_gives_the_same_and_counts_once(make):
    search = make.search()
    assert search.ask() is search.ask()
    step(search)
    assert search.ask() is search.ask()
    assert [member.explorations for member in search.members] == [1]


def test_keys_are_those_of_seed_generation_and_deployment(make):
    search = make.search(seed=9)
    step(search)
    search.ask()
    assert search.deployment_key(3) == deployment_key(9, 1, 3)


def test_misuse_is_refused(make):
    search = make.search()
    with pytest.raises(InputError, match="no solution was evaluated"):
        search.best  # noqa: B018
    with pytest.raises(InputError, match=r"tell\(\) without ask"):
        search.tell(make.evaluation(0.1, (0, 0, 0), rules=8))
    search.ask()
    with pytest.raises(InputError, match=r"seed 7, generation 0: strength has shape \(2, 8\)"):
        search.tell(make.evaluation(0.1, (0, 0), rules=8))
    with pytest.raises(InputError, match="fitness is nan"):
        search.tell(mean_of([make.deployment(math.nan, (0, 0, 0), rules=8)]))
    step(search)  # a refused evaluation leaves the run as it was


def told(make, fitnesses, **settings) -> Search:
    """A run that was told these fitnesses, with agent 0 contributing most."""
    search, rng = make.search(**settings), np.random.default_rng(0)
    for fitness in fitnesses:
        search.ask()
        search.tell(make.evaluation(fitness, (9, 0, 0), rules=8, rng=rng))
    return search


def kept(search: Search) -> int:
    """Rules of agent 1 in the next solution that come from its parent's agent 1."""
    solution = search.ask()
    return int((solution.origin_generation[1] < solution.generation).sum())


def test_every_setting_of_the_search_is_heeded(make):
    assert told(make, [0.0], min_deployments=3).trial().wanted() == [0, 1, 2]
    assert told(make, [0.0], max_redeployments=7).trial().limit == 8
    assert len(told(make, [0.0, -0.9], omega0=0.0).members) == 1
    assert len(told(make, [0.0, -0.9], omega0=2.0).members) == 2
    assert kept(told(make, [0.5])) == 2  # 8 / 4
    assert kept(told(make, [0.5, -0.9], omega0=0.0)) == 1  # floor(8 (0.25 - 1 / 100))
    assert kept(told(make, [0.5, -0.9], omega0=0.0, varrho=4.0)) == 0
    for seed in range(3):
        child = told(make, [0.5], exchange=False, seed=seed).ask()
        assert not (child.origin_kind == Origin.COPIED).any()
    ailta = {"acceptance": "ailta", "ailta_rejections": 1}
    assert told(make, [0.0, -0.03, -0.03], **ailta).members[0].generation == 2
    assert told(make, [0.0, -0.05, -0.05], **ailta).members[0].generation == 0
    assert told(make, [0.0, -0.05, -0.05], **ailta, ailta_threshold=0.05).members[0].generation == 2
    assert told(make, [0.0, -0.07, -0.07], **ailta, ailta_patience=1).members[0].generation == 2
    assert told(make, [0.0, *[-0.1] * 3], **ailta, ailta_patience=1).members[0].generation == 3
    capped = told(make, [0.0, *[-0.1] * 3], **ailta, ailta_patience=1, ailta_threshold_max=0.09)
    assert capped.members[0].generation == 0
    with pytest.raises(InputError, match=r"search\.acceptance"):
        make_acceptance(SimpleNamespace(acceptance="none"), agents=2, rules=2)


@pytest.mark.parametrize("rejected", [3, 30])
def test_ailta_resumes_in_the_middle_of_its_row_and_patience(make, rejected):
    search = told(make, [0.5, *[0.1] * rejected], acceptance="ailta")
    resumed = Search.from_state(SearchSettings(acceptance="ailta"), *search.state(), source=make.source)
    for fitness in [0.43] * 4:  # accepted after five rejections once theta has grown to 0.08
        verdicts = []
        for run in (search, resumed):
            run.ask()
            verdicts.append(run.tell(make.evaluation(fitness, (9, 0, 0), rules=8)).accepted)
        assert verdicts[0] == verdicts[1]
    assert search.members[0].generation == resumed.members[0].generation


@pytest.mark.parametrize("acceptance", ["domination", "ailta"])
@pytest.mark.parametrize("stop", [0, 1, 13, 30])
@pytest.mark.parametrize("asked", [False, True])
def test_a_resumed_run_goes_on_exactly(make, tmp_path, acceptance, stop, asked):
    settings = SearchSettings(acceptance=acceptance, generations=45)
    search = make.search(agents=4, rules=10, seed=3, acceptance=acceptance, generations=45)
    for _ in range(stop):
        step(search)
    if asked:
        search.ask()
    arrays, meta = search.state()
    np.savez(tmp_path / "state.npz", **arrays)
    with np.load(tmp_path / "state.npz", allow_pickle=False) as stored:
        arrays = dict(stored)
    resumed = Search.from_state(settings, arrays, json.loads(json.dumps(meta, allow_nan=False)), source=make.source)

    again, other = resumed.state(), search.state()
    assert again[1] == other[1]
    assert again[0].keys() == other[0].keys()
    for name, array in again[0].items():
        np.testing.assert_array_equal(array, other[0][name], err_msg=name)
        assert array.dtype == other[0][name].dtype
    while not search.finished:
        assert resumed.ask().equals(search.ask())
        assert plain(step(resumed)) == plain(step(search))
    assert resumed.finished
    assert resumed.best.solution.equals(search.best.solution)
    assert [m.explorations for m in resumed.members] == [m.explorations for m in search.members]


def test_the_best_is_remembered_when_ailta_has_left_it(make):
    search = make.search(acceptance="ailta")
    for fitness in (0.5, *[0.47] * 6):
        search.ask()
        search.tell(make.evaluation(fitness, (0, 0, 0), rules=8))
    assert [member.generation for member in search.members] == [6]
    resumed = Search.from_state(SearchSettings(acceptance="ailta"), *search.state(), source=make.source)
    assert resumed.best.generation == 0
    assert resumed.best.fitness == 0.5


def test_runs_differ_by_seed_only(make):
    def rows(seed):
        search = make.search(seed=seed, generations=8)
        return [plain(step(search)) for _ in range(8)]

    assert rows(1) == rows(1)
    assert rows(1) != rows(2)
    assert not np.array_equal(make.search(seed=1).ask().ids, make.search(seed=2).ask().ids)
    shares = [
        [int((told(make, [0.5], seed=seed).ask().origin_kind[a] == Origin.COPIED).sum()) for a in (1, 2)]
        for seed in range(6)
    ]
    assert len({tuple(share) for share in shares}) > 1  # told the same, what is exchanged still differs by seed
