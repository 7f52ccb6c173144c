"""Who transmits, who receives, and where the packets go: worked cases without shadowing."""

import math

import numpy as np
import pytest

from slcs2_jax.grammar import vocabulary
from slcs2_jax.grammar.vocabulary import PAPER
from tests.oracle import air, radio, sensing, words
from tests.oracle.words import NO_ACTION

FULL, HALF = vocabulary.FULL, vocabulary.HALF
SO, SI, C, SOURCE, SINK = range(5)


def send(target, channel=0, power=FULL):
    return PAPER.send_action(target, channel, power)


def collect(channel=0, power=FULL):
    return PAPER.collect_action(channel, power)


def gain(apart):
    """Received power in mW at full power."""
    return 10 ** ((-20.05 - 28 * math.log10(apart)) / 10)


def communicate(case, actions, channels=(True, True, True), draws=(1, 2)):
    """Hears, transmits and hands over; returns the accepted transmissions as (sender, receiver)."""
    state, work, world = case.state, case.work, case.world
    channels = np.array(channels)
    radio.jam_nodes(state.place, world, case.params, 1, 2, work.jam)
    radio.hear_beacons(state.place, world, channels, work.jam, case.params, 1, 2, work.floor, work.heard)
    sensing.enter_neighbours(state.place, work.heard, 0, state.known_time, state.known_place)
    work.action[:] = actions
    before = total(state)
    count = air.list_sends(state, world, case.params, work)
    count = air.list_serves(count, state, case.params, work, *draws)
    air.radiate(count, state.place, world, case.params, work, 1, 2)
    air.accept(count, state.holding, channels, case.params, work)
    n = len(state.holding)
    accepted = [m for m in range(count) if work.accepted[air.inbox(m, n, work)] == m]
    air.hand_over(count, state, work)
    air.measure_interference(count, channels, case.params, work, state.interference)
    assert total(state) == before
    return [(int(work.sender[m]), int(work.receiver[m])) for m in accepted]


def total(state):
    return state.depot.sum() + state.holding.sum()


@pytest.mark.parametrize("channel", range(3))
@pytest.mark.parametrize("power", [HALF, FULL])
def test_actions_are_read_as_the_vocabulary_writes_them(params, channel, power):
    for action in (collect(channel, power), *(send(t, channel, power) for t in range(5))):
        assert words.CHANNEL[action] == channel
        assert air.power_of(action, params) == pytest.approx(1.0 if power == FULL else 0.5, abs=1e-4)
        assert air.is_collect(action) != air.is_send(action)
        assert not air.is_move(action)
    assert not any(f(NO_ACTION) for f in (air.is_move, air.is_collect, air.is_send))


def test_collect_send_and_deliver(calm, make):
    case = make.place([(50, 0), (90, 0)], sink=(150, 0), params=calm)
    assert communicate(case, [collect(), NO_ACTION]) == [(2, 0)]
    assert case.state.depot.tolist() == [calm.packets - 1, 0]
    assert communicate(case, [send(SI), NO_ACTION]) == [(0, 1)]
    np.testing.assert_array_equal(case.state.history, [[False, False], [True, True]])
    assert communicate(case, [NO_ACTION, send(SINK)]) == [(1, 3)]
    assert case.state.depot.tolist() == [calm.packets - 1, 1]
    assert case.state.contribution.tolist() == [1, 1]
    assert not case.state.history.any()


def test_a_packet_given_back_loses_its_history(calm, make):
    case = make.place([(50, 0), (90, 0)], params=calm, holding=[0])
    assert communicate(case, [send(SOURCE), NO_ACTION]) == [(0, 2)]
    assert case.state.depot.tolist() == [calm.packets, 0]
    assert not case.state.history.any()


def test_sending_without_packet_or_target_puts_nothing_on_air(calm, make):
    case = make.place([(50, 0), (90, 0)], params=calm, holding=[0])
    assert communicate(case, [send(SINK), send(SO)]) == []  # sink out of reach; 1 has no packet
    np.testing.assert_allclose(case.state.interference, calm.noise)


def test_interference_decides(calm, make):
    # 0 sends to 1 at 20 m, 2 to 3; the stranger is farther from 1 by the ratio for 10 dB, 2.276, and a little
    for ratio, decoded in ((2.2, False), (2.4, True)):
        stranger = 20 * ratio
        start = [(0, 100), (20, 100), (20 + stranger, 100), (20 + stranger + 5, 100)]
        case = make.place(start, params=calm, holding=[0, 2])
        moved = communicate(case, [send(C), NO_ACTION, send(C), NO_ACTION])
        assert ((0, 1) in moved) == decoded
        assert (2, 3) in moved
        own = 0.0 if decoded else gain(20)
        assert case.state.interference[1, 0] == pytest.approx(calm.noise + gain(stranger) + own)
        assert case.state.interference[0, 0] == pytest.approx(calm.noise + gain(20 + stranger))


def test_channels_do_not_interfere(calm, make):
    start = [(0, 100), (20, 100), (25, 100), (30, 100)]
    case = make.place(start, params=calm, holding=[0, 2])
    assert communicate(case, [send(C, 0), NO_ACTION, send(C, 1), NO_ACTION]) in ([(0, 1)], [(2, 1)])
    case = make.place(start, params=calm, holding=[0, 2])
    communicate(case, [send(C, 0), NO_ACTION, send(C, 1), NO_ACTION])
    # 2 is nearer to 1 and wins although both were decoded; the loser's signal counts as interference on its channel
    assert case.state.holding.tolist() == [True, True, False, False]
    assert case.state.interference[1].tolist() == pytest.approx([calm.noise + gain(20), calm.noise, calm.noise])
    assert case.state.interference[3].tolist() == pytest.approx(
        [calm.noise + gain(30), calm.noise + gain(5), calm.noise]
    )


def test_equally_strong_senders_tie_to_the_lowest(calm, make):
    case = make.place([(10, 100), (0, 100), (20, 100)], params=calm, holding=[1, 2])
    assert communicate(case, [NO_ACTION, send(C, 0), send(C, 1)]) == [(1, 0)]


def test_half_power_is_half_the_signal(calm, make):
    case = make.place([(0, 100), (20, 100)], params=calm, holding=[0])
    assert communicate(case, [send(C, 0, HALF), NO_ACTION]) == [(0, 1)]
    assert case.work.signal[0, 1] == pytest.approx(gain(20) / 2, rel=1e-3)
    case = make.place([(0, 500), (150, 500)], params=calm, holding=[0])  # 163 m reach at full, 127 m at half power
    assert communicate(case, [send(C, 0, HALF), NO_ACTION]) == []
    assert communicate(case, [send(C, 0, FULL), NO_ACTION]) == [(0, 1)]


def test_who_holds_or_transmits_does_not_receive(calm, make):
    case = make.place([(0, 100), (20, 100)], params=calm, holding=[0, 1])
    assert communicate(case, [send(C), NO_ACTION]) == []
    case = make.place([(50, 0), (60, 0)], params=calm, holding=[0])
    # the source transmits to 1 on channel 1, so it cannot take 0's packet there, but on channel 6
    assert (0, 2) not in communicate(case, [send(SOURCE, 0), collect(0)])
    case = make.place([(50, 0), (60, 0)], params=calm, holding=[0])
    assert communicate(case, [send(SOURCE, 1), collect(0)]) == [(0, 2), (2, 1)]


def test_the_sink_takes_one_packet_per_channel(calm, make):
    start = [(590, 0), (580, 0), (540, 0)]
    case = make.place(start, params=calm, holding=[0, 1, 2])
    assert communicate(case, [send(SINK, 0), send(SINK, 1), send(SINK, 1)]) == [(0, 4), (1, 4)]
    assert case.state.depot.tolist() == [calm.packets - 3, 2]
    eager = calm._replace(sinr=1e-9, log_sinr=-20.0)  # everything is decoded: still one per channel
    case = make.place(start, params=eager, holding=[0, 1, 2])
    assert communicate(case, [send(SINK, 0), send(SINK, 1), send(SINK, 1)]) == [(0, 4), (1, 4)]


def test_an_agent_takes_one_packet_over_all_channels(calm, make):
    case = make.place([(50, 0), (60, 0), (49, 0)], params=calm, holding=[1])
    assert communicate(case, [collect(0), send(SO, 1), NO_ACTION]) == [(1, 0)]
    assert case.state.depot[0] == calm.packets - 1  # the source's signal was decoded, but weaker: it keeps the packet
    assert case.state.interference[0].tolist() == pytest.approx([calm.noise + gain(50), calm.noise, calm.noise])


def test_the_source_serves_one_asker_per_channel_at_random(calm, make):
    start = [(30, 0), (35, 0), (40, 0), (45, 0)]
    served = set()
    for seed in range(60):
        case = make.place(start, params=calm)
        moved = communicate(case, [collect(0), collect(0), collect(0), collect(2)], draws=(seed, 2 * seed))
        assert len(moved) == 2
        assert moved[1] == (4, 3)
        served.add(moved[0][1])
    assert served == {0, 1, 2}


def test_the_source_transmits_no_more_packets_than_wait(calm, make):
    case = make.place([(30, 0), (35, 0)], params=calm)
    case.state.depot[:] = 1, calm.packets - 1
    assert communicate(case, [collect(1), collect(0)]) == [(2, 1)]  # channel 1 comes before channel 6
    case.state.holding[:] = False
    assert communicate(case, [collect(1), collect(0)]) == []


def test_asking_takes_hearing_the_source_and_empty_hands(calm, make):
    case = make.place([(30, 0), (300, 0)], params=calm, holding=[0])
    assert communicate(case, [collect(), collect()]) == []


def test_jammer_prevents_and_is_measured(calm, make):
    case = make.place([(60, 0), (100, 0)], params=calm, holding=[0], jammer=(100, 30))
    communicate(case, [send(SI), NO_ACTION])
    assert case.state.holding.tolist() == [True, False]
    at_0 = gain(math.hypot(40, 30))
    assert case.state.interference[0].tolist() == pytest.approx([calm.noise + at_0, calm.noise, calm.noise])
    assert communicate(case, [send(SI, 1), NO_ACTION]) == [(0, 1)]


def test_send_targets_are_those_heard_now(calm, make):
    case = make.place([(100, 0), (110, 0), (400, 0)], params=calm, holding=[0])
    case.state.known_time[0, 2] = 0
    case.state.known_place[0, 2] = (105, 0)  # remembered nearer than 1, but out of reach
    case.work.role[0] = (3, 2, 2)
    assert communicate(case, [send(SI), NO_ACTION, NO_ACTION]) == [(0, 1)]
