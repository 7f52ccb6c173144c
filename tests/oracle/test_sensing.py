"""Knowledge, roles, clauses and the lidar: worked cases."""

import numpy as np
import pytest

from slcs2_jax.grammar.vocabulary import PAPER
from tests.oracle import inputs, sensing


def roles(case, i, only_heard=False):
    sensing.find_roles(
        i, only_heard, case.state.place, case.world.sink_estimate, case.state.known_time, case.state.known_place,
        case.work.heard, case.work.role[i], case.work.distance[i],
    )  # fmt: skip
    return case.work.role[i].tolist(), case.work.distance[i, :3].tolist()


def know(case, i, j, where, time=0):
    case.state.known_time[i, j] = time
    case.state.known_place[i, j] = where


def test_source_and_sink_are_candidates_without_any_knowledge(make):
    case = make.place([(100, 0), (200, 0)])
    assert roles(case, 0) == ([2, 3, 2], [100.0, 500.0, 100.0])


def test_so_and_si_must_be_strictly_nearer_to_source_and_sink(make):
    case = make.place([(100, 0)] * 4)
    know(case, 0, 1, (90, 0))
    know(case, 0, 2, (105, 0))
    know(case, 0, 3, (100, 0))  # the same place: nearer to neither, and closest of all
    assert roles(case, 0) == ([1, 2, 3], [10.0, 5.0, 0.0])


def test_one_neighbour_can_have_every_role(make):
    case = make.place([(100, 40), (100, 10)])
    know(case, 0, 1, (100, 10))
    assert roles(case, 0) == ([1, 1, 1], [30.0, 30.0, 30.0])


def test_ties_go_to_the_lowest_node(make):
    case = make.place([(100, 0), (110, 0), (110, 0)])
    know(case, 0, 2, (110, 0))
    know(case, 0, 1, (110, 0))
    assert roles(case, 0)[0] == [3, 1, 1]


def test_roles_undefined_at_the_source(make):
    case = make.place([(0, 0), (900, 0)])
    assert roles(case, 0) == ([-1, 3, 2], [-1.0, 600.0, 0.0])


def test_roles_among_the_heard_leave_out_what_is_only_remembered(make):
    case = make.place([(100, 0), (110, 0), (120, 0)])
    know(case, 0, 1, (110, 0))
    know(case, 0, 2, (120, 0))
    case.work.heard[0, 2] = True
    assert roles(case, 0, only_heard=True) == ([-1, 2, 2], [-1.0, 20.0, 20.0])
    case.work.heard[0, 2:5] = (False, True, True)
    assert roles(case, 0, only_heard=True) == ([3, 4, 3], [100.0, 500.0, 100.0])


def test_agents_use_the_sink_where_they_believe_it(make):
    case = make.place([(100, 0), (0, 0)], sink_estimate=(0.0, 300.0))
    know(case, 0, 1, (100, 10))  # nearer to the estimate, farther from the true sink
    assert roles(case, 0)[0][1] == 1
    assert sensing.believed_place(0, 3, case.state.place, case.world.sink_estimate, case.state.known_place) == (0, 300)


def test_heard_agents_enter_the_knowledge(make):
    case = make.place([(1, 2), (3, 4), (5, 6)])
    case.work.heard[0, 1] = True
    sensing.enter_neighbours(case.state.place, case.work.heard, 7, case.state.known_time, case.state.known_place)
    np.testing.assert_array_equal(case.state.known_time, [[-1, 7, -1], [-1] * 3, [-1] * 3])
    np.testing.assert_array_equal(case.state.known_place[0, 1], [3, 4])


def share(case):
    state, work = case.state, case.work
    sensing.share_knowledge(
        work.heard, state.known_time, state.known_place, state.jammer_range,
        work.shared_time, work.shared_place, work.shared_range,
    )  # fmt: skip


def test_sharing_takes_the_newest_and_reaches_one_hop_at_a_time(make):
    case = make.place([(0, 0)] * 4)
    know(case, 2, 3, (9, 9), 8)
    know(case, 1, 3, (1, 1), 5)
    know(case, 2, 0, (4, 4), 8)  # what 1 hears from 2 about 0; nobody learns of himself
    case.work.heard[0, 1] = case.work.heard[1, 2] = True
    case.state.jammer_range[:] = (0.0, 3.0, 5.0, 0.0)
    share(case)
    np.testing.assert_array_equal(case.state.known_time[:, 3], [5, 8, 8, -1])
    np.testing.assert_array_equal(case.state.known_place[:3, 3], [[1, 1], [9, 9], [9, 9]])
    np.testing.assert_array_equal(case.state.known_time[:, 0], [-1, 8, 8, -1])
    np.testing.assert_array_equal(case.state.jammer_range, [3, 5, 5, 0])
    share(case)
    np.testing.assert_array_equal(case.state.known_time[0], [-1, -1, -1, 8])


def truth(params, apart, holding=False, in_reach=False, interference=(0.0, 0.0, 0.0)):
    """The numbers of the clauses that hold."""
    words = sensing.observe(holding, in_reach, np.array(interference), np.array(apart, float), params)
    bits = inputs.unpack_clauses(np.array(words, np.int64))
    return {k for k in range(97) if bits[k // 32] >> (k % 32) & 1}


NOTHING = [-1, -1, -1, 0, 0, -1, -1, -1]  # with sink and source, which are always known


@pytest.mark.parametrize("seed", range(8))
def test_every_clause_by_its_definition(params, seed):
    rng = np.random.default_rng(seed)
    apart = rng.choice([1.0, 2.9, 50.0, 50.9, 52.1, 163.0, 166.0, 300.0], 8)
    apart[[0, 1, 2, 7]] *= rng.choice([1, 1, -1], 4)
    apart[apart < 0] = -1
    held, reach = rng.integers(0, 2, 2)
    noise = rng.choice([params.receive, params.receive * 1.01], 3)
    expected = {1 if held else 2, 3 if reach else 4}
    expected |= {PAPER.noise_clause(k) for k in range(3) if noise[k] <= params.receive}
    right_hand = apart[[0, 1, 2, 5, 6, 7]]
    for left, x in enumerate(apart[:5]):
        for right, y in enumerate(right_hand):
            holds = (x < y, x > y, abs(x - y) <= max(params.speed, params.tolerance * y))
            if x >= 0 and y >= 0:
                expected |= {PAPER.distance_clause(left, op, right) for op in range(3) if holds[op]}
    assert truth(params, apart, held, reach, noise) == expected


def test_undefined_operands_make_clauses_false(params):
    loud = (1.0, 1.0, 1.0)
    assert truth(params, [-1, -1, -1, 10, 10, -1, -1, -1], interference=loud) == {2, 4}


def test_equality_holds_within_a_step_or_two_percent(params):
    equal = PAPER.distance_clause(4, 2, 3)  # source = threshold
    less = PAPER.distance_clause(4, 0, 3)
    for source, threshold, holds in ((48, 50, True), (47.9, 50, False), (196, 200, True), (195.9, 200, False)):
        clauses = truth(params, [-1, -1, -1, 0, source, threshold, -1, -1])
        assert (equal in clauses) == holds
        assert less in clauses


def test_packing_of_clauses_is_invertible():
    words = np.random.default_rng(0).integers(0, 2**32, (5, 7, 4), dtype=np.uint32)
    words[..., 3] &= 1  # 97 clauses
    np.testing.assert_array_equal(inputs.unpack_clauses(inputs.pack_clauses(words)), words)


@pytest.mark.parametrize(
    ("walls", "others", "expected"),
    [
        ({}, [(30, 0)], (False, 0, 0)),
        ({}, [(10, 0)], (True, 10, 0)),
        ({}, [(8, 0), (0, 6)], (True, 0, 6)),
        ({"vertical": [(5, -3, 3)]}, [(30, 0)], (True, 4.5, 0)),
        ({"vertical": [(-5, 3, 9)]}, [(30, 0)], (True, -4.5, 3)),
        ({"vertical": [(5, -3, 3)], "horizontal": [(4, -1, 1)]}, [(30, 0)], (True, 0, 3.5)),
        ({"vertical": [(5, -3, 3)]}, [(4.5, 0)], (True, 4.5, 0)),
        ({"vertical": [(10.6, -3, 3)], "horizontal": [(-10.6, -1, 1)]}, [(30, 0)], (False, 0, 0)),
        ({"vertical": [(10.5, -3, 3)]}, [(30, 0)], (True, 10, 0)),
    ],
)
def test_nearest_obstacle(params, make, walls, others, expected):
    case = make.place([(0, 0), *others], **walls)
    found = sensing.nearest_obstacle(0, case.state.place, len(others) + 1, case.world, params)
    assert found == expected


@pytest.mark.parametrize("chain", [(0, 1, 2), (2, 1, 0)])
def test_sharing_is_simultaneous_in_whatever_order_agents_stand(make, chain):
    last, middle, first = chain
    case = make.place([(0, 0)] * 4)
    know(case, first, 3, (9, 9), 8)
    case.work.heard[last, middle] = case.work.heard[middle, first] = True
    share(case)
    assert case.state.known_time[middle, 3] == 8
    assert case.state.known_time[last, 3] == -1
