"""Which generations are a final's."""

from __future__ import annotations

import pytest

from slcs2_jax.config import InputError, Search
from slcs2_jax.search.final import Schedule


def test_a_final_is_the_end_of_a_period():
    turns = [Schedule(4, 10).turn(generation) for generation in range(20)]
    assert turns[:10] == turns[10:]
    assert turns[:10] == [None] * 4 + [(4, 0), (4, 1), (4, 2), (4, 3), (2, 0), (2, 1)]
    assert Schedule(2, 5).turn(4) == (2, 1)
    assert Schedule(8, 30).turn(16) == (8, 0)


def test_what_is_asked_for_together_ends_with_the_round():
    stops = [Schedule(4, 10).stop(generation) for generation in range(12)]
    assert stops == [4, 4, 4, 4, 8, 8, 8, 8, 10, 10, 14, 14]


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"finalists": 6}, "search.finalists=6: accepted is a power of two"),
        ({"finalists": 16, "final_every": 100, "generations": 100}, "search.finalists=16: accepted is at most "),
        ({"final_every": 9, "generations": 9}, "search.final_every=9: accepted is at least 10"),
        ({"generations": 30}, "generations=30: accepted is a multiple of search.final_every=20"),
    ],
)
def test_settings_that_do_not_go_together_are_refused(values, says):
    with pytest.raises(InputError, match=says):
        Search(**({"name": "informed", "generations": 20} | values))
    Search(**({"generations": 20} | values))  # no matter to other searches
