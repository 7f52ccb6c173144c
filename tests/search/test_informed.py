"""The informed search: what it asks for, what finals decide, and that it goes on exactly from any moment."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.results.figures import Figures
from slcs2_jax.search import Deployment, Informed, deployment_key, mean_of
from slcs2_jax.search.packing import pack_state, unpack_state
from tests.search.test_knowledge import problem

SETTINGS = {
    "name": "informed",
    "acceptance": "best",
    "parent": "tournament",
    "starts": 4,
    "racing": True,
    "inherit_quality": True,
    "population": 6,
    "finalists": 4,
    "final_every": 12,
    "final_deployments": 3,
    "final_share": 0.0,
    "generations": 24,
}


def search_of(make, *, mode: str = "reflex", kind=Informed, **values) -> Informed:
    return kind(problem(make, mode=mode, agents=4, search=SETTINGS | values))


def toy(solution, key) -> Deployment:
    """A world in which low actions, and reflexes in half of the swarm, are good."""
    good = (solution.rules.action < 20).astype(np.float64)
    rng = np.random.default_rng([int(word) for word in key])
    flags = 0.0 if solution.rules.reflex is None else float(solution.rules.reflex[:2].mean())
    return Deployment(
        fitness=float(good.mean() + flags - 1 + rng.normal(0, 0.05)),
        delivered=int(good.sum()),
        steps=10,
        contribution=good.sum(axis=1).astype(np.int64),
        figures=Figures(
            quality=rng.normal(size=good.shape).astype(np.float32),
            strength=good.astype(np.float32),
            error=(1 - good).astype(np.float32),
            usage=rng.integers(0, 2, good.shape).astype(np.int32),
        ),
    )


def evaluated(search: Informed, solution):
    search.problem.check(solution, solution.generation)
    trial = search.trial(solution)
    while not trial.complete:
        for index in trial.wanted():
            trial.add(index, toy(solution, deployment_key(search.problem.seed, solution.generation, index)))
    return trial.result()


def step(search: Informed, batch: int = 1) -> list:
    solutions = search.ask(batch)
    return search.tell(solutions, [evaluated(search, solution) for solution in solutions])


def again(search: Informed) -> Informed:
    """The search that goes on from where this one is, after a file."""
    arrays, meta = pack_state(search.state())
    resumed = type(search)(search.problem)
    resumed.restore(unpack_state(arrays, json.loads(json.dumps(meta, allow_nan=False)), PAPER))
    return resumed


def test_flags_alone_change_in_half_of_the_children(make):
    search = search_of(make, generations=240, final_every=120)
    alone = both = 0
    while not search.finished:
        [solution] = search.ask()
        parents = [member.solution for member in search.members if member.generation == solution.parent]
        step(search)
        if parents and solution.generation % 120 < 114:
            same = np.array_equal(solution.ids, parents[0].ids)
            alone, both = alone + same, both + (not same)
    assert alone + both > 200
    assert 0.4 < alone / (alone + both) < 0.62


def test_a_child_with_flags_alone_has_what_its_parent_had_learnt(make):
    search = search_of(make)
    search = type(search)(
        dataclasses.replace(search.problem, knowledge=dataclasses.replace(search.problem.knowledge, alone=1.0))
    )
    for _ in range(4):
        step(search)
    [child] = search.ask()
    [parent] = [member for member in search.members if member.generation == child.parent]
    used = parent.evaluation.used
    np.testing.assert_array_equal(child.rules.quality[used], parent.evaluation.figures.quality[used])
    assert (child.rules.quality[~used] == 0).all()


def test_finals_deploy_the_fittest_again_and_halve_them(make):
    search = search_of(make)
    for _ in range(6):
        step(search)
    fittest = sorted(search.members, key=lambda member: -member.fitness)[:4]
    before = {member.generation: member.evaluation.deployments for member in search.members}
    asked = []
    for _ in range(4):
        [solution] = search.ask()
        asked.append(solution.parent)
        assert any(np.array_equal(solution.ids, member.solution.ids) for member in fittest)
        step(search)
    assert asked == [member.generation for member in fittest]
    after = {member.generation: member for member in search.members}
    assert all(after[one].evaluation.deployments == before[one] + 3 for one in asked)
    two = sorted((after[one] for one in asked), key=lambda member: -member.fitness)[:2]
    for expected in two:
        [solution] = search.ask()
        assert solution.parent == expected.generation
        step(search)
    assert search.best.evaluation.deployments >= 7
    [solution] = search.ask()
    assert solution.parent in {member.generation for member in search.members}  # evolution goes on
    assert search.generation == 12


def test_luck_does_not_make_a_winner(make):
    search = search_of(make, racing=False, max_redeployments=0)
    for fitness in (0.30, 0.28, 0.1, 0.1, 0.1, 0.1):
        search.tell(search.ask(), [make.evaluation(fitness, (1, 0, 0, 0), rules=20)])
    assert search.best.fitness == 0.30
    for fitness in (-0.3, 0.28, 0.0, 0.0, 0.28, 0.0):  # of the finalists, in their order
        search.tell(search.ask(), [make.evaluation(fitness, (1, 0, 0, 0), rules=20)])
    assert search.best.generation == 1
    assert search.best.fitness == pytest.approx(0.28)
    assert search.best.evaluation.fitnesses == (0.28, 0.28, 0.28)


def test_one_deployment_counts_less_than_many(make):
    search = search_of(make, racing=False, finalists=2, final_every=4, final_deployments=6)

    def tell(*fitnesses: float) -> None:
        deployed = [make.deployment(fitness, (1, 0, 0, 0), rules=20) for fitness in fitnesses]
        search.tell(search.ask(), [mean_of(deployed)])

    tell(0.30)
    tell(0.10)
    tell(*[0.30] * 6)
    tell(*[0.10] * 6)
    assert search.best.evaluation.deployments == 7
    tell(0.31)
    assert search.best.generation == 0
    tell(*[0.33] * 7)
    assert search.best.generation == 5


@pytest.mark.parametrize("batch", [1, 3, 8])
def test_several_at_once_end_with_the_round(make, batch):
    search, sizes = search_of(make), []
    while not search.finished:
        sizes.append(len(step(search, batch)))
    assert sum(sizes) == 24
    assert sizes == {1: [1] * 24, 3: [3, 3, 3, 1, 2] * 2, 8: [6, 4, 2] * 2}[batch]


@pytest.mark.parametrize("mode", ["none", "suggested", "reflex"])
@pytest.mark.parametrize("asked", [False, True])
@pytest.mark.parametrize("stop", [0, 3, 5, 6, 8, 10, 11, 12, 19])
def test_a_resumed_run_goes_on_exactly(make, mode, asked, stop):
    search = search_of(make, mode=mode)
    for _ in range(stop):
        step(search)
    if asked:
        search.ask()
    resumed = again(search)
    (arrays, meta), (others, other) = (pack_state(run.state()) for run in (resumed, search))
    assert meta == other
    assert all(np.array_equal(array, others[name]) for name, array in arrays.items())
    while not search.finished:
        assert resumed.ask()[0].equals(search.ask()[0])
        assert [repr(one) for one in step(resumed)] == [repr(one) for one in step(search)]
    assert resumed.best.solution.equals(search.best.solution)
    assert resumed.best.fitness == search.best.fitness
    assert resumed.episodes == search.episodes


def test_a_run_that_goes_further_is_as_one_made_at_once(make):
    long, short = search_of(make), search_of(make, generations=12)
    while not short.finished:
        step(short)
    further = Informed(long.problem)
    further.restore(short.state())
    for search in (long, further):
        while not search.finished:
            step(search)
    assert further.best.solution.equals(long.best.solution)
    assert further.episodes == long.episodes


def test_other_knowledge_is_refused(make):
    search = search_of(make)
    step(search)
    from slcs2_jax.config import InputError

    with pytest.raises(InputError, match=r"knowledge\.rules: is not the list that the run was begun with"):
        search_of(make, mode="none").restore(search.state())


@pytest.mark.parametrize("acceptance", ["domination", "ailta"])
def test_it_goes_with_other_acceptances(make, acceptance):
    search = search_of(make, acceptance=acceptance)
    while not search.finished:
        step(search)
    assert search.best.fitness > -1


@pytest.mark.parametrize("values", [{"homogeneous": True}, {"variation": "random"}, {"inherit_quality": False}])
def test_it_goes_with_other_parts(make, values):
    search = search_of(make, **values)
    while not search.finished:
        step(search)
    assert search.best.evaluation.deployments >= 3


def test_episodes_end_with_one_final(make):
    search = search_of(make, episodes=60, generations=500)
    rounds = []
    while not search.finished:
        [solution] = search.ask()
        final = search._turn(solution.generation)
        rounds.append(final)
        if final is None:
            assert search.episodes + 18 < 60  # (4 + 2) finalists, 3 deployments each
        step(search)
    assert rounds[-6:] == [(4, 0), (4, 1), (4, 2), (4, 3), (2, 0), (2, 1)]
    assert all(one is None for one in rounds[:-6])
    assert 60 <= search.episodes < 60 + 6
    assert search.best.evaluation.deployments >= 4


@pytest.mark.parametrize(("share", "each"), [(0.0, 3), (0.2, 4), (0.5, 10)])
def test_the_final_takes_its_share_of_the_episodes(make, share, each):
    search = search_of(make, episodes=120, generations=500, final_share=share)
    before = None
    while not search.finished:
        [solution] = search.ask()
        before = search.episodes if before is None and search._turn(solution.generation) else before
        step(search)
    assert before is not None
    assert search.episodes - before == 6 * each
    assert 120 <= search.episodes < 120 + 6  # it begins as soon as what is left is what it takes
    assert search.best.evaluation.deployments >= 2 * each


def test_a_final_in_many_worlds_is_of_whole_rounds(make):
    search = through_worlds(make, episodes=180, generations=500, final_share=0.45)  # 13 for each of 6 finalists
    while not search.finished:
        [solution] = search.ask()
        if search._turn(solution.generation):
            assert len(search.trial(solution).wanted()) == 12
        step(search)
    assert 180 <= search.episodes < 180 + 6
    assert search.best.evaluation.deployments % 6 == 0


@pytest.mark.parametrize("episodes", [1, 7, 18])
def test_episodes_that_do_not_cover_a_final_are_spent_without_one(make, episodes):
    search = search_of(make, episodes=episodes, generations=500)
    while not search.finished:
        assert all(search._turn(solution.generation) is None for solution in search.ask())
        step(search)
    assert episodes <= search.episodes < episodes + 6
    assert search.best.evaluation.deployments >= 1


@pytest.mark.parametrize("batch", [1, 4])
@pytest.mark.parametrize("early", [1, 3, 8])
def test_a_resumed_search_ends_by_its_episodes_alike(make, batch, early):
    values = {"episodes": 60, "generations": 500, "batch": batch}
    search = search_of(make, **values)
    while search.episodes < 60 - 18 and search.generation < 500:
        step(search, batch)
    for _ in range(early):
        if not search.finished:
            search = again(search)
            step(search, batch)
    at_once = search_of(make, **values)
    while not at_once.finished:
        step(at_once, batch)
    while not search.finished:
        search = again(search)
        step(search, batch)
    assert (search.generation, search.episodes) == (at_once.generation, at_once.episodes)
    assert search.best.solution.equals(at_once.best.solution)


WORLDS = {"worlds": 6, "kinds": 3}


def through_worlds(make, *, kind=Informed, **values):
    search = search_of(make, kind=kind, **values)
    return kind(dataclasses.replace(search.problem, **WORLDS))


@pytest.mark.parametrize("stop", [0, 3, 5, 9, 11, 12, 19])
def test_a_search_through_worlds_goes_on_exactly(make, stop):
    search = through_worlds(make)
    for _ in range(stop):
        step(search)
    search.ask()
    resumed, counts = again(search), []
    while not search.finished:
        assert [repr(one) for one in step(resumed)] == [repr(one) for one in step(search)]
    assert resumed.best.fitness == search.best.fitness
    assert resumed.episodes == search.episodes
    counts = [member.evaluation.deployments for member in search.members]
    assert search.best.evaluation.offset is None
    assert search.best.evaluation.deployments % 6 == 0
    assert search.best.evaluation.deployments >= 12  # in a final, too
    assert min(counts) >= 3


def test_candidates_that_lose_in_some_worlds_are_spared_the_rest(make):
    search, alone = through_worlds(make, final_every=120, generations=120), through_worlds(make, racing=False)
    while search.generation < 100:
        step(search)
    assert 100 * 3 < search.episodes < 100 * 5
    while not alone.finished:
        step(alone)
    assert alone.episodes == 24 * 6


def test_another_number_of_worlds_is_refused(make):
    from slcs2_jax.config import InputError

    search = through_worlds(make)
    step(search)
    with pytest.raises(InputError, match="the state is that of a run in 6 worlds"):
        search_of(make).restore(search.state())
