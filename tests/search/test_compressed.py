"""What is kept compressed comes back without loss, from a file too."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest

from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.search.compressed import compress, decompress
from slcs2_jax.search.member import Member
from slcs2_jax.search.packing import pack_members, pack_solutions, unpack_members, unpack_solutions
from slcs2_jax.search.solution import Solution


def test_values_come_back(make):
    values = {"a": np.arange(6, dtype=np.int8).reshape(2, 3), "b": 0.1, "c": (1.5, 2.5), "d": np.zeros((0, 2), bool)}
    again = decompress(compress(values))
    assert (again["b"], again["c"]) == (0.1, (1.5, 2.5))
    for name in ("a", "d"):
        np.testing.assert_array_equal(again[name], values[name])
        assert again[name].dtype == values[name].dtype


def test_a_member_has_the_solution_and_the_evaluation_that_it_was_made_of(make):
    solution = make.solution(agents=3, rules=8)
    evaluation = make.evaluation(0.25, (1, 0, 2), rules=8, rng=np.random.default_rng(1))
    member = Member(solution, evaluation)
    assert member.solution.equals(solution)
    again = member.evaluation
    for name in ("fitnesses", "delivered", "steps"):
        assert getattr(again, name) == getattr(evaluation, name)
    np.testing.assert_array_equal(again.contribution_sum, evaluation.contribution_sum)
    for name, array in evaluation.figures.arrays().items():
        np.testing.assert_array_equal(again.figures.arrays()[name], array)
        assert again.figures.arrays()[name].dtype == array.dtype


def test_reflexes_and_initial_quality_are_kept(make):
    plain = make.solution(agents=2, rules=3)
    flags, quality = np.eye(2, 3, dtype=bool), np.full((2, 3), 0.5, np.float32)
    solution = Solution.of(plain.values() | {"reflex": flags, "quality": quality})
    again = Member(solution, make.evaluation(0.1, (0, 0), rules=3)).solution
    np.testing.assert_array_equal(again.rules.reflex, flags)
    np.testing.assert_array_equal(again.rules.quality, quality)
    assert again.equals(solution)
    both = unpack_solutions(pack_solutions([plain, solution]), PAPER)
    assert both[0].equals(plain)
    assert both[1].equals(solution)
    assert unpack_solutions(pack_solutions([]), PAPER) == []


def test_a_member_takes_a_third_of_its_arrays_at_most(make):
    solution = make.solution(agents=12, rules=100)
    evaluation = make.evaluation(0.0, (0,) * 12, rules=100)
    whole = sum(array.nbytes for array in solution.arrays().values()) + 4 * evaluation.figures.strength.nbytes
    member = Member(solution, evaluation)
    assert sum(map(len, member.data)) < whole / 3


def test_what_is_stored_comes_back_and_nothing_else_does(make):
    member = Member(make.solution(), make.evaluation(0.25, (1, 0), rng=np.random.default_rng(1)), 7)
    packed = pack_members([member, member])
    again = unpack_members(packed, PAPER)[1]
    assert again.data == member.data
    assert (again.fitness, again.generation, again.explorations) == (0.25, member.generation, 7)
    solution, evaluation = member.data
    for data in (b"", solution[:-5], evaluation, b"\x02\0\0\0{}", solution[:4] + b"x" + solution[5:]):
        with pytest.raises((ValueError, KeyError, TypeError, AttributeError, struct.error, zlib.error)):
            Member.of_data(data, evaluation, 0, PAPER)
    with pytest.raises(ValueError, match="not as long as it says"):
        unpack_members(packed | {"data": packed["data"][:-3]}, PAPER)
