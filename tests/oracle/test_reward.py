"""Rewards: every case of its definition."""

import math

import numpy as np
import pytest

from slcs2_jax.grammar import vocabulary
from slcs2_jax.grammar.vocabulary import PAPER
from tests.oracle import reward
from tests.oracle.words import NO_ACTION

MOVE, COLLECT = 0, PAPER.collect_action(0, vocabulary.FULL)


@pytest.mark.parametrize(
    ("progress", "returned", "cost", "expected"),
    [
        (0, 0, 0.1, -0.1),
        (math.e - 1, 0, 0, 1),
        (1 - math.e, 0, 0, -1),
        (math.e - 1, -2, 0.05, -1.05),
    ],
)
def test_reward_of(progress, returned, cost, expected):
    assert reward.reward_of(progress, returned, cost) == pytest.approx(expected)


def earn(case, action, held, transfers=(), moved=None):
    """Rewards; transfers are (sender, receiver) that were accepted, held is who had a packet before."""
    work, state = case.work, case.state
    work.action[:] = action
    work.held[:] = held
    work.moved[:] = state.place[: len(held)] if moved is None else moved
    work.accepted[:] = -1
    for m, (u, v) in enumerate(transfers):
        work.sender[m], work.receiver[m], work.channel[m] = u, v, 0
        work.accepted[reward.inbox(m, len(held), work)] = m
    reward.transfer_progress(len(transfers), state.place, case.world.sink_estimate, work)
    reward.reward_agents(state, case.world, case.params, work, state.reward)
    return state.reward.tolist()


def test_a_held_packet_earns_its_way_and_empty_hands_the_way_back(make):
    case = make.place([(100, 0), (100, 50)], holding=[0])
    earned = earn(case, [MOVE, MOVE], [True, False], moved=[(102, 0), (100, 48)])
    back = math.hypot(100, 50) - math.hypot(100, 48)
    assert earned == pytest.approx([math.log(3) - 0.1, back - 0.1])


def test_sender_and_receiver_share_the_progress_before_the_step(make):
    case = make.place([(100, 0), (150, 0)], holding=[1])
    earned = earn(case, [COLLECT, MOVE], [True, False], [(0, 1)], moved=[(100, 0), (152, 0)])
    assert earned == pytest.approx([math.log(51) - 0.05, math.log(51) - 0.1])


def test_sending_backwards_is_punished_and_delivery_counts_to_the_sink(make):
    case = make.place([(100, 0), (60, 0)], holding=[1])
    assert earn(case, [COLLECT, NO_ACTION], [True, False], [(0, 1)]) == pytest.approx([-math.log(41) - 0.05, 0])
    case = make.place([(550, 0), (0, 0)])
    assert earn(case, [COLLECT, MOVE], [True, False], [(0, 3)]) == pytest.approx([math.log(51) - 0.05, -0.1])


def test_collecting_counts_as_received_at_the_source(make):
    case = make.place([(0, 80), (100, 0)], holding=[0, 1])
    earned = earn(case, [COLLECT, COLLECT], [False, False], [(2, 0), (2, 1)])
    lost = math.hypot(600, 80) - 600
    assert earned == pytest.approx([-math.log(lost + 1) - 0.05, math.log(101) - 0.05])


def test_giving_back_loses_the_way_made(make):
    case = make.place([(100, 0), (0, 9)])
    assert earn(case, [COLLECT, COLLECT], [True, False], [(0, 2)]) == pytest.approx([-math.log(101) - 0.05, -0.05])


def test_the_believed_sink_counts(make):
    case = make.place([(100, 0), (0, 9)], sink_estimate=(100.0, 50.0), holding=[0])
    earned = earn(case, [MOVE, NO_ACTION], [True, False], moved=[(100, 2), (0, 9)])
    assert earned == pytest.approx([math.log(3) - 0.1, 0])


def test_no_action_earns_nothing(make):
    case = make.place([(100, 0), (0, 9)], holding=[0])
    np.testing.assert_array_equal(earn(case, [NO_ACTION] * 2, [True, False]), [0, 0])
