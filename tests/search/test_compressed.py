"""What is kept compressed comes back without loss, from a file too."""

import struct
import zlib
from dataclasses import fields

import numpy as np
import pytest

from slcs2_jax.results.figures import Figures
from slcs2_jax.search.compressed import Compressed
from slcs2_jax.search.member import Member
from slcs2_jax.search.solution import Solution


def test_a_record_comes_back_with_every_value(make):
    solution = make.solution(agents=3, rules=8)
    evaluation = make.evaluation(0.25, (1, 0, 2), rules=8, rng=np.random.default_rng(1))
    assert Compressed(solution).record().equals(solution)
    again = Compressed(evaluation).record()
    pairs = [(getattr(evaluation, field.name), getattr(again, field.name)) for field in fields(evaluation)]
    for here, there in pairs:
        if isinstance(here, Figures):
            pairs += zip(here.arrays().values(), there.arrays().values(), strict=True)
            continue
        np.testing.assert_array_equal(here, there)
        assert getattr(here, "dtype", None) == getattr(there, "dtype", None)


def test_a_member_takes_a_third_of_its_arrays_at_most(make):
    solution = make.solution(agents=12, rules=100)
    evaluation = make.evaluation(0.0, (0,) * 12, rules=100)
    whole = sum(array.nbytes for array in solution.arrays().values()) + 4 * evaluation.figures.strength.nbytes
    member = Member(solution, evaluation)
    assert sum(map(len, member.data)) < whole / 3


def test_what_is_stored_comes_back_and_nothing_else_does(make):
    member = Member(make.solution(), make.evaluation(0.25, (1, 0), rng=np.random.default_rng(1)), 7)
    again = Member.of_data(*member.data, 7)
    assert again.data == member.data
    assert (again.fitness, again.generation, again.explorations) == (0.25, member.generation, 7)
    solution, evaluation = member.data
    for data in (b"", solution[:-5], evaluation, b"\x02\0\0\0{}", solution[:4] + b"x" + solution[5:]):
        with pytest.raises((ValueError, KeyError, TypeError, AttributeError, struct.error, zlib.error)):
            Compressed.of_data(Solution, data)
