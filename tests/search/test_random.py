"""Random search: nothing is inherited, the best is kept, and it spends the episodes it is given."""

from __future__ import annotations

import numpy as np

from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.search import Origin, RandomSearch, Slcs2
from slcs2_jax.search.packing import pack_state, unpack_state


def run(search: RandomSearch, make, fitnesses) -> list:
    verdicts = []
    for fitness in fitnesses:
        verdicts += search.tell(search.ask(), [make.evaluation(fitness, (1, 0, 0), rules=8)])
    return verdicts


def test_every_solution_is_new_and_random(make):
    search, seen = make.search(kind=RandomSearch, generations=9), set()
    for generation in range(9):
        [solution] = search.ask()
        assert (solution.generation, solution.parent) == (generation, -1)
        assert (solution.origin_kind == (Origin.RANDOM if generation else Origin.INITIAL)).all()
        seen.add(solution.ids.tobytes())
        search.tell([solution], [make.evaluation(0.9, (1, 0, 0), rules=8)])
    assert len(seen) == 9
    assert search.finished


def test_it_begins_with_the_solution_that_the_papers_search_begins_with(make):
    [first], [other] = make.search(kind=RandomSearch).ask(), make.search(kind=Slcs2).ask()
    assert first.equals(other)


def test_the_fittest_is_kept(make):
    search = make.search(kind=RandomSearch)
    verdicts = run(search, make, [-0.5, 0.1, 0.1, 0.3])
    assert [verdict.accepted for verdict in verdicts] == [True, True, False, True]
    assert [verdict.removed for verdict in verdicts] == [(), (0,), (), (1,)]
    assert [member.generation for member in search.members] == [3]
    assert search.best.fitness == 0.3
    assert np.isnan(verdicts[0].novelty)
    assert all(0.5 < verdict.novelty <= 1 for verdict in verdicts[1:])


def test_it_goes_on_exactly(make):
    search = make.search(kind=RandomSearch)
    run(search, make, [0.0, 0.2, -1.0])
    search.ask()
    again = RandomSearch(search.problem)
    again.restore(unpack_state(*pack_state(search.state()), PAPER))
    assert again.ask()[0].equals(search.ask()[0])
    assert again.best.solution.equals(search.best.solution)
    for one in (search, again):
        run(one, make, [0.1])
    assert again.ask()[0].equals(search.ask()[0])
    assert again.episodes == search.episodes == 4
