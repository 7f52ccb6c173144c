"""Sending, collecting, interference and who holds what, by hand."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from slcs2_jax.swarm import packets

NOISE, P_RS = 10**-9.4, 10**-8.2
STRONG = 1e-4  # mW, far above everything else
FULL, HALF = 1.0, 10**-0.301


def run(make, state, links, radio=None, **actions):
    """The state after the step, and what was on the air, in NumPy."""
    intent = make.intent(state.x.shape[0], **actions)
    return jax.device_get(make.transfer(state, links, intent, make.physics(radio=radio).radio))


def world(make, n=4, channels=(0,), **fields):
    return make.state(make.arena([(100 * i, 0) for i in range(n)], channels=channels), **fields)


def holders(state):
    return np.flatnonzero(state.holding).tolist()


def history(state, agent):
    """Agents that held the packet in an agent's buffer."""
    words = state.history[:, agent]
    return [i for i in range(len(state.holding)) if words[i // 32] >> (i % 32) & 1]


def test_a_packet_is_sent(make):
    after, air = run(make, world(make, holding=[0]), make.links(4, default=STRONG), sends={0: (1, 0, FULL)})
    assert holders(after) == [1]
    assert history(after, 1) == [0, 1]
    assert history(after, 0) == []
    assert air.accepted[0, 0, 1]
    assert air.accepted.sum() == 1


def test_histories_grow_from_hand_to_hand(make):
    state, links = world(make, holding=[2]), make.links(4, default=STRONG)
    for sender, receiver in ((2, 0), (0, 3), (3, 0), (0, 1)):
        state, _ = run(make, state, links, sends={sender: (receiver, 0, FULL)})
    assert holders(state) == [1]
    assert history(state, 1) == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("power", "level", "passes"),
    [
        (P_RS * 1.01, FULL, True),
        (P_RS * 0.99, FULL, False),
        (P_RS * 1.01, HALF, False),
        (P_RS * 2.01, HALF, True),
    ],
)
def test_a_packet_too_weak_stays(make, power, level, passes):
    links = make.links(4, {(0, 1): power})
    after, _ = run(make, world(make, holding=[0]), links, sends={0: (1, 0, level)})
    assert holders(after) == [1 if passes else 0]
    assert history(after, 1 if passes else 0) == ([0, 1] if passes else [0])


@pytest.mark.parametrize(("jam", "passes"), [(0.0, True), (STRONG / 11, True), (STRONG / 9.9, False), (STRONG, False)])
def test_the_jammer_drowns_packets_on_its_channel(make, jam, passes):
    jamming = np.zeros((3, 6), np.float32)
    jamming[0] = jam
    links = make.links(4, default=STRONG, jamming=jamming, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0])
    assert holders(run(make, state, links, sends={0: (1, 0, FULL)})[0]) == [1 if passes else 0]
    assert holders(run(make, state, links, sends={0: (1, 1, FULL)})[0]) == [1]


def test_a_holder_refuses(make):
    after, air = run(make, world(make, holding=[0, 1]), make.links(4, default=STRONG), sends={0: (1, 0, FULL)})
    assert holders(after) == [0, 1]
    assert air.wanted[0, 0, 1]
    assert not air.decoded.any()


def test_a_holder_that_gives_its_packet_away_still_refuses_in_that_step(make):
    """It held one when the step began, and was transmitting."""
    links = make.links(4, default=STRONG)
    after, _ = run(make, world(make, holding=[0, 1]), links, sends={0: (1, 0, FULL), 1: (2, 0, FULL)})
    assert 0 in holders(after)


@pytest.mark.parametrize("case", ["nothing held", "no target"])
def test_nothing_goes_on_the_air(make, case):
    state = world(make, holding=[] if case == "nothing held" else [0])
    node = 6 if case == "no target" else 1
    after, air = run(make, state, make.links(4, default=STRONG), sends={0: (node, 0, FULL)})
    assert (air.signal == 0).all()
    assert holders(after) == holders(state)
    np.testing.assert_allclose(after.interference, NOISE, rtol=1e-5)


def test_of_two_senders_as_strong_neither_is_decoded(make):
    links = make.links(4, {(0, 2): 1e-6, (1, 2): 1e-6})
    after, _ = run(make, world(make, holding=[0, 1]), links, sends={0: (2, 0, FULL), 1: (2, 0, FULL)})
    assert holders(after) == [0, 1]


def test_the_one_ten_times_stronger_is_captured(make):
    for ratio, winner in ((9.9, [0, 1]), (10.1, [0, 2])):
        links = make.links(4, {(0, 2): 1e-5, (1, 2): ratio * 1e-5})
        after, _ = run(make, world(make, holding=[0, 1]), links, sends={0: (2, 0, FULL), 1: (2, 0, FULL)})
        assert holders(after) == winner


def test_other_conversations_interfere(make):
    """3 talks to the sink; at 2, agent 0 must be ten times as strong as 3."""
    for ratio, taken in ((9.9, False), (10.1, True)):
        links = make.links(4, {(0, 2): ratio * 1e-6, (3, 2): 1e-6, (3, 5): STRONG})
        after, _ = run(make, world(make, holding=[0, 3]), links, sends={0: (2, 0, FULL), 3: (5, 0, FULL)})
        assert (2 in holders(after)) == taken


def test_channels_are_orthogonal(make):
    links = make.links(4, {(0, 2): 1e-6, (1, 3): 1e-6, (0, 3): 1e-6, (1, 2): 1e-6}, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 1])
    assert holders(run(make, state, links, sends={0: (2, 0, FULL), 1: (3, 0, FULL)})[0]) == [0, 1]
    assert holders(run(make, state, links, sends={0: (2, 0, FULL), 1: (3, 2, FULL)})[0]) == [2, 3]


def test_over_all_channels_an_agent_takes_the_strongest_and_the_losers_keep_theirs(make):
    links = make.links(4, {(0, 3): 1e-6, (1, 3): 3e-6, (2, 3): 2e-6}, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 1, 2])
    after, air = run(make, state, links, sends={i: (3, i, FULL) for i in range(3)})
    assert air.decoded.sum() == 3
    assert holders(after) == [0, 2, 3]
    assert history(after, 3) == [1, 3]
    after, _ = run(make, state, links, sends={0: (3, 0, FULL), 1: (3, 1, 0.5), 2: (3, 2, FULL)})
    assert history(after, 3) == [2, 3]  # at half power 1 is weaker


def test_ties_on_a_channel_go_to_the_lowest_transmitter(make):
    """Only a threshold below 0 dB lets both be decoded."""
    links = make.links(4, {(i, 5): 1e-6 for i in range(4)})
    state = world(make, holding=[1, 2])
    after, air = run(make, state, links, {"sinr_threshold_db": -10.0}, sends={i: (5, 0, FULL) for i in (1, 2)})
    assert air.decoded.sum() == 2
    assert holders(after) == [2]


def test_ties_over_channels_go_to_the_lowest_transmitter(make):
    links = make.links(4, {(i, 3): 1e-6 for i in range(3)}, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 1, 2])
    for first, second in ((0, 2), (2, 0)):
        after, _ = run(make, state, links, sends={1: (3, first, FULL), 2: (3, second, FULL)})
        assert history(after, 3) == [1, 3]


def test_the_sink_takes_one_packet_per_channel(make):
    links = make.links(4, default=1e-6, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 1, 2])
    after, _ = run(make, state, links, sends={i: (5, i, FULL) for i in range(3)})
    assert holders(after) == []
    assert int(after.delivered) == 3
    np.testing.assert_array_equal(after.contribution, [1, 1, 1, 0])
    after, _ = run(make, state, links, sends={i: (5, 0, FULL) for i in range(3)})
    assert int(after.delivered) == 0  # they drown each other


def test_contributions_go_to_all_who_held_the_packet(make):
    links = make.links(4, default=STRONG)
    state = world(make, holding=[0], contribution=[5, 0, 0, 0])
    state, _ = run(make, state, links, sends={0: (2, 0, FULL)})
    np.testing.assert_array_equal(state.contribution, [5, 0, 0, 0])
    state, _ = run(make, state, links, sends={2: (5, 0, FULL)})
    np.testing.assert_array_equal(state.contribution, [6, 0, 1, 0])
    assert history(state, 2) == []


@pytest.mark.parametrize("n", [33, 64])
def test_histories_of_many_agents(make, n):
    state, links = world(make, n, holding=[n - 1]), make.links(n, default=STRONG)
    for sender, receiver in ((n - 1, 0), (0, 31), (31, n + 1)):
        state, _ = run(make, state, links, sends={sender: (receiver, 0, FULL)})
    assert int(state.delivered) == 1
    assert np.flatnonzero(state.contribution).tolist() == sorted({0, 31, n - 1})
    assert not state.history.any()


def test_the_source_takes_a_packet_back_and_forgets_who_held_it(make):
    links = make.links(4, default=STRONG)
    state = world(make, holding=[0], waiting=7)
    state, _ = run(make, state, links, sends={0: (4, 0, FULL)})
    assert (holders(state), int(state.waiting), history(state, 0)) == ([], 8, [])
    np.testing.assert_array_equal(state.contribution, 0)
    state, _ = run(make, state, links, collects={1: (0, FULL)})
    assert (holders(state), int(state.waiting), history(state, 1)) == ([1], 7, [1])


def test_the_source_takes_one_packet_back_per_channel(make):
    links = make.links(4, default=STRONG, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 1, 2], waiting=0)
    after, _ = run(make, state, links, sends={i: (4, i, FULL) for i in range(3)})
    assert (holders(after), int(after.waiting)) == ([], 3)


def test_the_source_does_not_receive_on_the_channel_on_which_it_serves(make):
    links = make.links(4, default=STRONG, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0], waiting=5)
    links = make.replace(links, power=links.power.at[0, 4].set(1e-2))  # far stronger than all else, where it matters
    same, _ = run(make, state, links, sends={0: (4, 1, FULL)}, collects={1: (1, FULL)})
    assert 0 in holders(same)
    other, _ = run(make, state, links, sends={0: (4, 2, FULL)}, collects={1: (1, FULL)})
    assert (holders(other), int(other.waiting)) == ([1], 5)


def test_collecting(make):
    after, air = run(make, world(make), make.links(4, default=STRONG), collects={2: (0, FULL)})
    assert (holders(after), int(after.waiting), history(after, 2)) == ([2], 299, [2])
    assert air.accepted[0, 4, 2]


@pytest.mark.parametrize("case", ["not heard", "holds one", "none waiting"])
def test_the_source_does_not_serve(make, case):
    heard = [(2, 3)] if case == "not heard" else [(2, 4)]
    links = make.links(4, default=STRONG, heard=heard)
    state = world(make, holding=[2] if case == "holds one" else [], waiting=0 if case == "none waiting" else 9)
    after, air = run(make, state, links, collects={2: (0, FULL)})
    assert (air.signal == 0).all()
    assert int(after.waiting) == int(state.waiting)
    assert holders(after) == holders(state)


@pytest.mark.parametrize(("level", "served"), [(FULL, True), (HALF, False)])
def test_the_source_serves_with_the_power_that_is_asked_for(make, level, served):
    links = make.links(4, {(2, 4): 1.5 * P_RS})
    after, air = run(make, world(make), links, collects={2: (0, level)})
    assert (2 in holders(after)) == served
    assert air.signal[0, 4, 2] == pytest.approx(1.5 * P_RS * level, rel=1e-3)
    assert int(after.waiting) == (299 if served else 300)


def test_the_source_serves_one_per_channel(make):
    links = make.links(4, default=STRONG, channels=3)
    state = world(make, channels=(0, 1, 2))
    after, _ = run(make, state, links, collects={i: (i % 3, FULL) for i in range(4)})
    assert int(after.waiting) == 297
    assert {1, 2} < set(holders(after))
    assert (0 in holders(after)) != (3 in holders(after))


@pytest.mark.parametrize("waiting", [0, 1, 2])
def test_the_source_gives_no_more_than_it_has_and_the_first_channels_come_first(make, waiting):
    links = make.links(4, default=STRONG, channels=3)
    state = world(make, channels=(0, 1, 2), waiting=waiting)
    after, air = run(make, state, links, collects={3: (0, FULL), 1: (1, FULL), 0: (2, FULL)})
    assert sorted(holders(after)) == sorted([3, 1, 0][:waiting])
    assert int(after.waiting) == 0
    assert air.signal.any(axis=(1, 2)).sum() == waiting


def test_a_packet_given_back_is_not_served_in_the_same_step(make):
    links = make.links(4, default=STRONG, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0], waiting=0)
    after, _ = run(make, state, links, sends={0: (4, 2, FULL)}, collects={1: (0, FULL)})
    assert (holders(after), int(after.waiting)) == ([], 1)


def test_the_source_chooses_uniformly_among_those_who_ask(make):
    """0, 1 and 3 ask, 2 asks on another channel; over many steps and episodes each is served a third of the time."""
    radio = make.physics().radio
    links = make.links(4, default=STRONG, channels=3)
    intent = make.intent(4, collects={0: (0, FULL), 1: (0, FULL), 2: (1, FULL), 3: (0, FULL)})
    state = world(make, channels=(0, 1, 2))

    def served(t, key):
        after, _ = packets.transfer(make.replace(state, t=t, key=jnp.stack([key, key])), links, intent, radio)
        return after.holding

    times = jnp.arange(3000, dtype=jnp.int32)
    for t, key in ((times, jnp.full(3000, 7, jnp.uint32)), (times * 0, times.astype(jnp.uint32))):
        counts = np.asarray(jax.jit(jax.vmap(served))(t, key)).sum(axis=0)
        assert counts[2] == 3000
        assert counts[[0, 1, 3]].sum() == 3000
        assert stats.chisquare(counts[[0, 1, 3]]).pvalue > 1e-3


def test_the_source_interferes_like_any_other(make):
    """0 sends to 1 while the source serves 2: 1 hears both, and 2 too."""
    powers = {(0, 1): 9.9e-6, (4, 1): 1e-6, (4, 2): 1e-6, (0, 2): 9e-8}
    both = {"sends": {0: (1, 0, FULL)}, "collects": {2: (0, FULL)}}
    after, _ = run(make, world(make, holding=[0]), make.links(4, powers), **both)
    assert holders(after) == [0, 2]
    powers |= {(0, 1): 10.1e-6, (0, 2): 1.1e-7}
    after, _ = run(make, world(make, holding=[0]), make.links(4, powers), **both)
    assert holders(after) == [1]


def test_noise_and_interference_by_hand(make):
    """0 -> 1 and 2 -> 3 on channel 1, both get through; the source serves nobody; the jammer sits on channel 1."""
    powers = {(0, 1): 1e-4, (2, 3): 2e-4, (0, 3): 3e-6, (2, 1): 4e-6, (0, 2): 5e-5}
    jamming = np.zeros((3, 6), np.float32)
    jamming[0, :4] = [1e-7, 2e-7, 3e-7, 4e-7]
    links = make.links(4, powers, jamming=jamming, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 2])
    after, _ = run(make, state, links, sends={0: (1, 0, FULL), 2: (3, 0, 0.5)})
    assert holders(after) == [1, 3]
    expected = [
        NOISE + 1e-7 + 0.5 * 5e-5,  # 0 hears 2, not itself
        NOISE + 2e-7 + 0.5 * 4e-6,  # 1 hears 2; what it decoded does not count
        NOISE + 3e-7 + 5e-5,
        NOISE + 4e-7 + 3e-6,
    ]
    np.testing.assert_allclose(after.interference[0], expected, rtol=1e-5)
    np.testing.assert_allclose(after.interference[1:], NOISE, rtol=1e-5)


def test_a_signal_that_is_not_accepted_is_interference_to_the_one_it_was_for(make):
    links = make.links(4, {(0, 1): 1e-4, (2, 1): 2e-4}, channels=3)
    state = world(make, channels=(0, 1, 2), holding=[0, 2])
    after, _ = run(make, state, links, sends={0: (1, 0, FULL), 2: (1, 1, FULL)})
    np.testing.assert_allclose(after.interference[:, 1], [NOISE + 1e-4, NOISE, NOISE], rtol=1e-5)


def test_interference_survives_beside_a_signal_a_billion_times_stronger(make):
    """Taking the wanted signal from the total would leave nothing, or less, of the others."""
    links = make.links(4, {(0, 1): 1e2, (2, 1): 1e-7, (2, 3): STRONG})
    after, air = run(make, world(make, holding=[0, 2]), links, sends={0: (1, 0, FULL), 2: (3, 0, FULL)})
    assert air.accepted[0, 0, 1]
    assert after.interference[0, 1] == pytest.approx(NOISE + 1e-7, rel=1e-5)


def test_idle_agents_and_movers_put_nothing_on_the_air(make):
    state = world(make, holding=[0])
    after, air = run(make, state, make.links(4, default=STRONG), moves={0: (0, 5, 5)})
    assert (air.signal == 0).all()
    assert holders(after) == [0]
