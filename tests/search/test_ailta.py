from __future__ import annotations

import math

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.search import Ailta

IDS = [[1, 2]]


def ailta(make, **changes) -> Ailta:
    return Ailta(make.problem(agents=1, rules=2, **{f"ailta_{name}": value for name, value in changes.items()}))


def feed(make, search: Ailta, fitnesses, start: int = 0) -> list[bool]:
    return [
        search.consider(make.member(fitness, IDS, start + place)).accepted for place, fitness in enumerate(fitnesses)
    ]


def test_better_and_equal_are_accepted_worse_are_not(make):
    assert feed(make, ailta(make), [-1.0, -0.5, -0.5, -0.51, -0.5, -0.4]) == [True, True, True, False, True, True]


def test_a_worse_one_is_accepted_only_after_five_rejections_in_a_row(make):
    assert feed(make, ailta(make), [0.0] + [-0.03] * 6) == [True] + [False] * 5 + [True]


def test_an_acceptance_ends_the_row(make):
    fitnesses = [0.0, *[-0.03] * 4, 0.0, *[-0.03] * 6]
    assert feed(make, ailta(make), fitnesses) == [True, *[False] * 4, True, *[False] * 5, True]


def test_the_threshold_is_below_the_best_ever_not_below_the_current(make):
    search = ailta(make)
    assert feed(make, search, [0.0] + [-0.03] * 6)[-1]  # current is now -0.03, best 0
    assert feed(make, search, [-0.05] * 7) == [False] * 7  # -0.05 < 0 - 0.04, though it is near the current
    assert feed(make, search, [-0.04]) == [True]  # the row is long enough: at the threshold is enough


def test_after_a_worse_one_the_row_starts_anew(make):
    assert feed(make, ailta(make), [0.0] + [-0.03] * 6 + [-0.035] * 6) == [True, *[False] * 5, True, *[False] * 5, True]


def test_the_threshold_grows_every_25_newcomers_to_its_limit_and_falls_back_at_a_new_best(make):
    search = ailta(make)
    feed(make, search, [0.0])
    seen = []
    for _ in range(300):
        seen.append(search.threshold)
        feed(make, search, [-0.9])
    assert seen[:25] == [0.04] * 25
    assert seen[25:50] == pytest.approx([0.08] * 25)
    assert seen[50] == pytest.approx(0.12)
    assert seen[-1] == 0.4
    feed(make, search, [0.1])
    assert search.threshold == 0.04


def test_as_fit_as_the_best_is_no_new_best(make):
    search = ailta(make)
    feed(make, search, [0.0] * 26)
    assert search.threshold == pytest.approx(0.08)


def test_verdicts(make):
    search = ailta(make)
    first = search.consider(make.member(0.0, IDS, 0))
    assert math.isnan(first.novelty)
    assert (first.removed, first.size) == ((), 1)
    second = search.consider(make.member(0.1, [[1, 3]], 1))
    assert (second.accepted, second.novelty, second.removed, second.size) == (True, 0.5, (0,), 1)
    [member] = search.members()
    search.consider(make.member(0.0, IDS, 2))
    assert search.members() == [member]


def test_bad_settings_are_refused(make):
    for changes in ({"rejections": -1}, {"patience": 0}, {"threshold": 0.5}, {"threshold": -0.1}):
        with pytest.raises(InputError, match=r"search\.ailta_"):
            ailta(make, **changes)
