from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.distance import dice

from slcs2_jax.config import InputError
from slcs2_jax.search import NoveltyIndex, novelty


def by_the_paper(x: np.ndarray, y: np.ndarray) -> float:
    """Delta b as the paper's three sums, rule by rule."""
    total = 0.0
    for here, there in zip(x.tolist(), y.tolist(), strict=True):
        lacked = sum(rule not in there for rule in here) + sum(rule not in here for rule in there)
        total += lacked / (len(here) + len(there))
    return total / len(x)


def u64(rows) -> np.ndarray:
    return np.array(rows, np.uint64)


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        ([[1, 2]], [[1, 2]], 0.0),
        ([[1, 2]], [[2, 1]], 0.0),  # order does not matter
        ([[1, 2]], [[3, 4]], 1.0),
        ([[1, 2]], [[1, 3]], 0.5),
        ([[1, 1]], [[1, 2]], 0.25),  # 1, 1 and 1 are shared, only 2 is lacked
        ([[1, 1]], [[2, 3]], 1.0),
        ([[1, 2], [3, 4]], [[3, 4], [1, 2]], 1.0),  # agent by agent: the same rules elsewhere do not count
        ([[1, 2], [3, 4]], [[1, 2], [3, 5]], 0.25),
    ],
)
def test_worked_cases(x, y, expected):
    assert novelty(u64(x), u64(y)) == expected
    assert novelty(u64(y), u64(x)) == expected


IDS = arrays(np.uint64, (2, 5), elements=st.integers(0, 9))


@settings(deadline=None, max_examples=80)
@given(st.lists(IDS, min_size=1, max_size=6), IDS, st.data())
def test_the_index_agrees_with_the_paper_while_members_come_and_go(members, newcomer, data):
    index = NoveltyIndex(2, 5)
    for ids in members:
        index.add(ids)
    for _ in range(2):
        expected = [by_the_paper(newcomer, ids) for ids in members]
        np.testing.assert_allclose(index.distances(newcomer), expected, rtol=0, atol=1e-15)
        assert len(index) == len(members)
        gone = data.draw(st.sets(st.integers(0, len(members) - 1), max_size=len(members)))
        index.remove(np.array(sorted(gone), int))
        members = [ids for place, ids in enumerate(members) if place not in gone]
        index.add(newcomer)
        members.append(newcomer)
        newcomer = data.draw(IDS)


@settings(deadline=None, max_examples=80)
@given(IDS, IDS)
def test_symmetric_within_0_and_1_and_0_for_itself(x, y):
    assert novelty(x, y) == novelty(y, x)
    assert 0 <= novelty(x, y) <= 1
    assert novelty(x, x) == 0


@pytest.mark.parametrize("seed", range(5))
def test_without_doubles_it_is_the_dice_distance(seed):
    rng = np.random.default_rng(seed)
    agents, rules, known = 6, 20, 50
    x, y = (np.stack([rng.permutation(known)[:rules] for _ in range(agents)]).astype(np.uint64) for _ in range(2))
    held = [np.array([np.isin(np.arange(known), row) for row in ids]) for ids in (x, y)]
    expected = np.mean([dice(here, there) for here, there in zip(*held, strict=True)])
    assert novelty(x, y) == pytest.approx(expected, abs=1e-15)


def test_all_64_bits_tell_rules_apart():
    x = u64([[0, 2**63]])
    assert novelty(x, u64([[2**63, 2**64 - 1]])) == 0.5
    assert novelty(x, u64([[1, 2**63 + 1]])) == 1.0


def test_an_empty_index_gives_no_distances():
    assert NoveltyIndex(1, 2).distances(u64([[1, 2]])).shape == (0,)
    index = NoveltyIndex(1, 2)
    index.add(u64([[1, 2]]))
    index.remove(np.array([0]))
    assert index.distances(u64([[1, 2]])).shape == (0,)


def test_wrong_ids_are_refused():
    with pytest.raises(InputError, match=r"uint64\[1, 2\] is expected"):
        NoveltyIndex(1, 2).add(u64([[1, 2, 3]]))
    with pytest.raises(InputError, match="int64"):
        NoveltyIndex(1, 2).distances(np.array([[1, 2]]))
