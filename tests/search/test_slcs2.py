from __future__ import annotations

import json
import math

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config import Search as SearchSettings
from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.results.figures import Figures
from slcs2_jax.search import Deployment, History, HistoryRow, Origin, SearchState, Slcs2, deployment_key, mean_of
from slcs2_jax.search.packing import pack_state, unpack_state
from slcs2_jax.search.slcs2 import check_parts


def goodness(action: np.ndarray) -> np.ndarray:
    """How good a rule is in the toy world: 1 for the six lowest of 57 actions, 0 else."""
    return (action < 6).astype(np.float64)


def toy(solution, key=(0, 0)) -> Deployment:
    """A world whose fitness is the share of good rules: good ones are strong and foreseen without error.

    Differs a little by deployment key, so that resuming with other keys would show.
    """
    good = goodness(solution.rules.action)
    noise = np.random.default_rng([int(word) for word in key]).normal(0, 0.01)
    return Deployment(
        fitness=float(2 * good.mean() - 1 + noise),
        delivered=int(good.sum()),
        steps=10,
        contribution=good.sum(axis=1).astype(np.int64),
        figures=Figures(
            quality=good.astype(np.float32),
            strength=good.astype(np.float32),
            error=(1 - good).astype(np.float32),
            usage=np.ones(good.shape, np.int32),
        ),
    )


def evaluated(search: Slcs2, solution):
    """The toy world's evaluation of a solution that the search asked for."""
    trial = search.trial(solution)
    while not trial.complete:
        for index in trial.wanted():
            trial.add(index, toy(solution, deployment_key(search.problem.seed, solution.generation, index)))
    return trial.result()


def step(search: Slcs2, history: History | None = None) -> HistoryRow:
    """One generation; `history` is that of all before it."""
    [solution] = search.ask()
    evaluation = evaluated(search, solution)
    [verdict] = search.tell([solution], [evaluation])
    return (history or History()).row(solution, evaluation, verdict)


def tell(search: Slcs2, evaluation):
    """Tell the one solution that the search asks for."""
    return search.tell(search.ask(), [evaluation])[0]


def stored(search: Slcs2) -> SearchState:
    """The search's state after it was in a file."""
    arrays, meta = pack_state(search.state())
    return unpack_state(arrays, json.loads(json.dumps(meta, allow_nan=False)), PAPER)


def again(search: Slcs2) -> Slcs2:
    """The search that goes on from where this one is."""
    resumed = Slcs2(search.problem)
    resumed.restore(stored(search))
    return resumed


def plain(row: HistoryRow) -> dict:
    return {name: None if value != value else value for name, value in vars(row).items()}


@pytest.mark.parametrize("acceptance", ["domination", "ailta"])
def test_the_search_gets_further_than_random_solutions(make, acceptance):
    runs = [make.search(agents=4, rules=20, seed=seed, acceptance=acceptance, generations=120) for seed in range(3)]
    found = []
    for search in runs:
        while not search.finished:
            step(search)
        found.append(2 * goodness(search.best.solution.rules.action).mean() - 1)
    rng = np.random.default_rng(0)
    chance = max(2 * goodness(make.source(80, rng)[1]).mean() - 1 for _ in range(3 * 120))
    assert min(found) > chance + 0.2


def test_rows_tell_what_happened(make):
    search, history = make.search(generations=60, agents=4, rules=20), History()
    best, families = -2.0, set()
    for generation in range(60):
        [asked], held = search.ask(), {member.generation for member in search.members}
        row = step(search, history)
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
    history = History()
    for fitness in (-0.5, -0.2, -0.2, -0.9):
        [solution], evaluation = search.ask(), make.evaluation(fitness, (0, 0, 0), rules=8)
        row = history.row(solution, evaluation, tell(search, evaluation))
    assert search.best.generation == row.best_generation == 1
    assert row.best == -0.2


def test_asking_twice_gives_the_same_and_counts_once(make):
    search = make.search()
    assert search.ask()[0] is search.ask()[0]
    step(search)
    assert search.ask()[0] is search.ask(3)[0]
    assert [member.explorations for member in search.members] == [1]


def test_misuse_is_refused(make):
    search = make.search()
    with pytest.raises(InputError, match="no solution was evaluated"):
        search.best  # noqa: B018
    first = make.search().ask()
    with pytest.raises(InputError, match=r"tell\(\) without ask"):
        search.tell(first, [make.evaluation(0.1, (0, 0, 0), rules=8)])
    asked = search.ask()
    with pytest.raises(InputError, match=r"seed 7, generation 0: strength has shape \(2, 8\)"):
        search.tell(asked, [make.evaluation(0.1, (0, 0), rules=8)])
    with pytest.raises(InputError, match="fitness is nan"):
        search.tell(asked, [mean_of([make.deployment(math.nan, (0, 0, 0), rules=8)])])
    for solutions in ([], [make.solution(agents=3, rules=8, generation=4)], asked * 2):
        with pytest.raises(InputError, match=r"accepts the solutions asked for, of generations \[0\]"):
            search.tell(solutions, [make.evaluation(0.1, (0, 0, 0), rules=8)] * len(solutions))
    step(search)  # a refused evaluation leaves the run as it was


def told(make, fitnesses, **settings) -> Slcs2:
    """A run that was told these fitnesses, with agent 0 contributing most."""
    search, rng = make.search(**settings), np.random.default_rng(0)
    for fitness in fitnesses:
        tell(search, make.evaluation(fitness, (9, 0, 0), rules=8, rng=rng))
    return search


def kept(search: Slcs2) -> int:
    """Rules of agent 1 in the next solution that come from its parent's agent 1."""
    [solution] = search.ask()
    return int((solution.origin_generation[1] < solution.generation).sum())


def test_every_setting_of_the_search_is_heeded(make):
    search = told(make, [0.0], min_deployments=3)
    assert search.trial(search.ask()[0]).wanted() == [0, 1, 2]
    search = told(make, [0.0], max_redeployments=7)
    assert search.trial(search.ask()[0]).limit == 8
    assert len(told(make, [0.0, -0.9], omega0=0.0).members) == 1
    assert len(told(make, [0.0, -0.9], omega0=2.0).members) == 2
    assert kept(told(make, [0.5])) == 2  # 8 / 4
    assert kept(told(make, [0.5, -0.9], omega0=0.0)) == 1  # floor(8 (0.25 - 1 / 100))
    assert kept(told(make, [0.5, -0.9], omega0=0.0, varrho=4.0)) == 0
    for seed in range(3):
        [child] = told(make, [0.5], exchange=False, seed=seed).ask()
        assert not (child.origin_kind == Origin.COPIED).any()
    ailta = {"acceptance": "ailta", "ailta_rejections": 1}
    assert told(make, [0.0, -0.03, -0.03], **ailta).members[0].generation == 2
    assert told(make, [0.0, -0.05, -0.05], **ailta).members[0].generation == 0
    assert told(make, [0.0, -0.05, -0.05], **ailta, ailta_threshold=0.05).members[0].generation == 2
    assert told(make, [0.0, -0.07, -0.07], **ailta, ailta_patience=1).members[0].generation == 2
    assert told(make, [0.0, *[-0.1] * 3], **ailta, ailta_patience=1).members[0].generation == 3
    capped = told(make, [0.0, *[-0.1] * 3], **ailta, ailta_patience=1, ailta_threshold_max=0.09)
    assert capped.members[0].generation == 0


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"name": "hill"}, "search.name=hill: accepted is one of slcs2, random, informed"),
        ({"acceptance": "novel"}, "acceptance=novel: accepted is one of domination, ailta"),
        ({"parent": "oldest"}, "search.parent=oldest: accepted is one of fewest"),
        ({"variation": "none"}, "search.variation=none: accepted is one of exchange"),
    ],
)
def test_parts_that_do_not_exist_are_refused(settings, says):
    with pytest.raises(InputError, match=says):
        check_parts(SearchSettings(**settings))


@pytest.mark.parametrize("rejected", [3, 30])
def test_ailta_resumes_in_the_middle_of_its_row_and_patience(make, rejected):
    search = told(make, [0.5, *[0.1] * rejected], acceptance="ailta")
    resumed = again(search)
    for fitness in [0.43] * 4:  # accepted after five rejections once theta has grown to 0.08
        verdicts = []
        for run in (search, resumed):
            verdicts.append(tell(run, make.evaluation(fitness, (9, 0, 0), rules=8)).accepted)
        assert verdicts[0] == verdicts[1]
    assert search.members[0].generation == resumed.members[0].generation


@pytest.mark.parametrize("acceptance", ["domination", "ailta"])
@pytest.mark.parametrize("stop", [0, 1, 13, 30])
@pytest.mark.parametrize("asked", [False, True])
def test_a_resumed_run_goes_on_exactly(make, acceptance, stop, asked):
    search = make.search(agents=4, rules=10, seed=3, acceptance=acceptance, generations=45)
    for _ in range(stop):
        step(search)
    if asked:
        search.ask()
    resumed = again(search)

    (arrays, meta), (others, other) = (pack_state(run.state()) for run in (resumed, search))
    assert meta == other
    assert arrays.keys() == others.keys()
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, others[name], err_msg=name)
        assert array.dtype == others[name].dtype
    while not search.finished:
        assert resumed.ask()[0].equals(search.ask()[0])
        assert plain(step(resumed)) == plain(step(search))
    assert resumed.finished
    assert resumed.best.solution.equals(search.best.solution)
    assert [m.explorations for m in resumed.members] == [m.explorations for m in search.members]


def test_a_state_of_another_run_is_refused(make):
    search = make.search()
    step(search)
    for changes, says in (({"seed": 8}, "with seed 7; accepted is .* with seed 8"), ({"rules": 9}, r"\[3, 8\] agents")):
        with pytest.raises(InputError, match=says):
            make.search(**changes).restore(stored(search))


def test_the_best_is_remembered_when_ailta_has_left_it(make):
    search = make.search(acceptance="ailta")
    for fitness in (0.5, *[0.47] * 6):
        tell(search, make.evaluation(fitness, (0, 0, 0), rules=8))
    assert [member.generation for member in search.members] == [6]
    resumed = again(search)
    assert resumed.best.generation == 0
    assert resumed.best.fitness == 0.5


# -- several at once ---------------------------------------------------------------------------------------------------


def generation(search: Slcs2, count: int) -> list:
    solutions = search.ask(count)
    return search.tell(solutions, [evaluated(search, solution) for solution in solutions])


def test_several_are_made_from_the_same_members_and_told_in_order(make):
    search = make.search(agents=4, rules=20, generations=40)
    first = search.ask(8)
    assert [(solution.generation, solution.parent) for solution in first] == [(number, -1) for number in range(8)]
    assert len({solution.ids.tobytes() for solution in first}) == 8
    generation(search, 8)
    held = [member.generation for member in search.members]
    children = search.ask(8)
    assert [child.generation for child in children] == list(range(8, 16))
    assert {child.parent for child in children} <= set(held)
    counts = {number: sum(child.parent == number for child in children) for number in held}
    assert max(counts.values()) - min(counts.values()) <= 1, "the least explored come first"
    verdicts = generation(search, 8)
    assert [verdict.explorations for verdict in verdicts] != [0] * 8 or len(held) >= 8
    assert search.generation == 16
    assert len(search.ask(100)) == 24  # as many as are left


@pytest.mark.parametrize("asked", [False, True])
def test_several_at_once_resume_exactly(make, asked):
    search = make.search(agents=4, rules=10, generations=24)
    generation(search, 6)
    if asked:
        search.ask(6)
    resumed = again(search)
    while not search.finished:
        verdicts = [
            [(one.accepted, one.explorations, one.removed) for one in generation(run, 6)] for run in (search, resumed)
        ]
        assert verdicts[0] == verdicts[1]
    assert resumed.best.solution.equals(search.best.solution)


def test_generations_are_whole_batches():
    assert SearchSettings(generations=12, batch=4).batch == 4
    with pytest.raises(InputError, match=r"generations=10: accepted is a multiple of search\.batch=4"):
        SearchSettings(generations=10, batch=4)


def test_a_budget_of_episodes_ends_the_search(make):
    search = make.search(generations=1000, episodes=25, min_deployments=4)
    while not search.finished:
        step(search)
    assert 25 <= search.episodes < 25 + 6
    assert search.generation <= 7


def test_runs_differ_by_seed_only(make):
    def rows(seed):
        search = make.search(seed=seed, generations=8)
        return [plain(step(search)) for _ in range(8)]

    assert rows(1) == rows(1)
    assert rows(1) != rows(2)
    assert not np.array_equal(make.search(seed=1).ask()[0].ids, make.search(seed=2).ask()[0].ids)
    shares = [
        [int((told(make, [0.5], seed=seed).ask()[0].origin_kind[a] == Origin.COPIED).sum()) for a in (1, 2)]
        for seed in range(6)
    ]
    assert len({tuple(share) for share in shares}) > 1  # told the same, what is exchanged still differs by seed
