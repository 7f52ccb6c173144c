from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.grammar import rule_ids
from slcs2_jax.search import Origin, Solution


def test_the_first_random_solution_holds_what_the_supply_gave(make):
    solution = make.problem(agents=3, rules=5).random_solution(make.supply(4), 0)
    drawn = make.supply(4).take(15)
    np.testing.assert_array_equal(solution.rules.mask.reshape(15, 4), drawn["mask"])
    np.testing.assert_array_equal(solution.rules.action.ravel(), drawn["action"])
    np.testing.assert_array_equal(solution.ids, rule_ids(solution.rules.mask, solution.rules.action))
    assert (solution.origin_kind == Origin.INITIAL).all()
    assert (solution.origin_agent == -1).all()
    assert (solution.generation, solution.parent, solution.shape) == (0, -1, (3, 5))


def test_arrays_cannot_be_changed(make):
    solution = make.solution()
    with pytest.raises(ValueError, match="read-only"):
        solution.rules.action[0, 0] = 1


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("mask", lambda array: array[..., :3]),
        ("mask", lambda array: array.astype(np.int64)),
        ("origin_agent", lambda array: array.astype(np.int32)),
        ("origin_kind", lambda array: array[:1]),
        ("action", lambda array: array.ravel()),
    ],
)
def test_a_wrong_array_is_named(make, field, change):
    values = make.solution().values()
    name = rf"solution\.{field} " if field.startswith("origin") else "rule-sets: "
    with pytest.raises(InputError, match=name):
        Solution.of(values | {field: change(values[field])})


def test_equals_sees_every_field(make):
    solution = make.solution()
    arrays = {name: array.copy() for name, array in solution.arrays().items()}
    values = arrays | {"generation": 0, "parent": -1}
    assert solution.equals(Solution.of(values))
    assert not solution.equals(Solution.of(values | {"generation": 1}))
    assert not solution.equals(Solution.of(values | {"reflex": np.zeros(solution.shape, bool)}))
    for name, array in arrays.items():
        other = array.copy()
        other.flat[-1] ^= 1
        assert not solution.equals(Solution.of(values | {name: other})), name


def test_a_later_random_solution_says_so(make):
    solution = make.problem(agents=2, rules=3).random_solution(make.supply(), 7)
    assert (solution.origin_kind == Origin.RANDOM).all()
    assert (solution.origin_generation == 7).all()
