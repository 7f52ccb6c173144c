"""The reward of every case by hand. The sink is at (600, 0), the source at the origin."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slcs2_jax.grammar.vocabulary import TOWARD

MOVE, TALK = 0.10, 0.05
STRONG = 1e-4


def rewards(make, places, *, ends=None, learning=None, estimate=None, links=None, channels=(0,), holding=(), **actions):
    """Everybody's reward for the actions when those in ``ends`` {agent: place} end up there."""
    n = len(places)
    arena = make.arena(places, estimate=estimate, channels=channels, width=3)
    state = make.state(arena, holding=list(holding))
    physics = make.physics(learning=learning)
    intent = make.intent(n, **actions)
    links = links or make.links(n, default=STRONG, channels=3)
    after, air = make.transfer(state, links, intent, physics.radio)
    for i, (x, y) in (ends or {}).items():
        after = make.replace(after, node_x=after.node_x.at[i].set(x), node_y=after.node_y.at[i].set(y))
    view = make.look(state, links, arena, physics)
    return np.asarray(make.reward(view, after, intent, air, physics))


def log(progress):
    return math.copysign(math.log(abs(progress) + 1), progress)


def to_sink(x, y, sink=(600, 0)):
    return math.dist((x, y), sink)


@pytest.mark.parametrize("end", [(302, 0), (298, 0), (300, 2), (300, 0)])
def test_carrying_a_packet(make, end):
    got = rewards(make, [(300, 0), (0, 50)], holding=[0], moves={0: (TOWARD, 600, 0)}, ends={0: end})
    assert got[0] == pytest.approx(log(300 - to_sink(*end)) - MOVE, abs=1e-4)


@pytest.mark.parametrize("end", [(298, 0), (302, 0), (300, 2), (300, 0)])
def test_without_a_packet_the_approach_to_the_source_counts(make, end):
    got = rewards(make, [(300, 0), (0, 50)], moves={0: (TOWARD, 0, 0)}, ends={0: end})
    assert got[0] == pytest.approx(300 - math.hypot(*end) - MOVE, abs=1e-4)


def test_a_transfer_credits_sender_and_receiver_with_the_same_progress(make):
    actions = {"sends": {0: (1, 0, 1.0)}, "moves": {2: (TOWARD, None, None)}}
    got = rewards(make, [(100, 0), (250, 30), (0, 50)], holding=[0], **actions)
    progress = 500 - to_sink(250, 30)
    assert got[0] == pytest.approx(log(progress) - TALK, abs=1e-4)
    assert got[2] == pytest.approx(-MOVE, abs=1e-6)


def test_a_receiver_is_credited_from_the_places_before_and_its_own_motion_does_not_count(make):
    got = rewards(
        make, [(100, 0), (250, 0)], holding=[0], sends={0: (1, 0, 1.0)}, moves={1: (TOWARD, 0, 0)}, ends={1: (248, 0)}
    )
    assert got[1] == pytest.approx(log(150) - MOVE, abs=1e-4)


def test_a_transfer_backwards_costs_both(make):
    got = rewards(make, [(250, 0), (100, 0)], holding=[0], sends={0: (1, 0, 1.0)}, moves={1: (TOWARD, None, None)})
    np.testing.assert_allclose(got, [log(-150) - TALK, log(-150) - MOVE], atol=1e-4)


def test_collecting_counts_as_receiving_at_the_source(make):
    got = rewards(make, [(30, 40), (0, 50)], collects={0: (0, 1.0)})
    assert got[0] == pytest.approx(log(600 - to_sink(30, 40)) - TALK, abs=1e-4)
    got = rewards(make, [(-30, 0), (0, 50)], collects={0: (0, 1.0)})
    assert got[0] == pytest.approx(log(-30) - TALK, abs=1e-4)


def test_delivering(make):
    got = rewards(make, [(480, 0), (0, 50)], holding=[0], sends={0: (3, 0, 1.0)})
    assert got[0] == pytest.approx(log(120) - TALK, abs=1e-4)


def test_giving_back(make):
    got = rewards(make, [(30, 0), (0, 50)], holding=[0], sends={0: (2, 0, 1.0)})
    assert got[0] == pytest.approx(log(-30) - TALK, abs=1e-4)


def test_asking_and_sending_in_vain(make):
    deaf = make.links(2, default=1e-12, channels=3)
    got = rewards(make, [(30, 0), (0, 50)], links=deaf, holding=[0], sends={0: (3, 0, 1.0)}, collects={1: (0, 1.0)})
    np.testing.assert_allclose(got, [-TALK, -TALK], atol=1e-6)


def test_distances_to_the_sink_are_to_where_it_is_believed(make):
    estimate = (580, 30)
    got = rewards(
        make, [(300, 0), (400, 0)], estimate=estimate, holding=[0, 1], sends={1: (3, 0, 1.0)},
        moves={0: (TOWARD, 0, 0)}, ends={0: (300, 2)},
    )  # fmt: skip
    assert got[0] == pytest.approx(log(to_sink(300, 0, estimate) - to_sink(300, 2, estimate)) - MOVE, abs=1e-4)
    # the packet ends where the sink truly is, as far from its estimate as that is off
    assert got[1] == pytest.approx(log(to_sink(400, 0, estimate) - math.hypot(20, 30)) - TALK, abs=1e-4)


def test_a_chain_in_one_step_credits_each_by_its_own_transfer(make):
    """0 hands to 1, which was free, on one channel, and 2 hands to 3 on another; 2 is not refilled."""
    places = [(100, 0), (200, 0), (300, 0), (350, 0)]
    got = rewards(make, places, channels=(0, 1, 2), holding=[0, 2], sends={0: (1, 0, 1.0), 2: (3, 1, 1.0)})
    np.testing.assert_allclose(got[[0, 2]], [log(100) - TALK, log(50) - TALK], atol=1e-4)


def test_costs_are_configurable(make):
    learning = {"cost_move": 1.5, "cost_communicate": 0.25}
    got = rewards(make, [(300, 0), (0, 50)], learning=learning, moves={0: (TOWARD, None, None)}, sends={1: (0, 0, 1.0)})
    np.testing.assert_allclose(got, [-1.5, -0.25], atol=1e-6)
