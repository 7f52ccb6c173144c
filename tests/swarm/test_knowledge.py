"""Knowledge K: entering, sharing with the newest winning, and the jammer's range."""

from __future__ import annotations

import numpy as np
import pytest

PLACES = [(10, 1), (20, 2), (30, 3), (40, 4)]
P_RS = 10**-8.2


def table(state):
    """What everybody knows: {(self, other): (time, x, y)}."""
    time, x, y = (np.asarray(a) for a in (state.known_time, state.known_x, state.known_y))
    n = len(time)
    return {
        (me, other): (int(time[other, me]), float(x[other, me]), float(y[other, me]))
        for me in range(n)
        for other in range(n)
        if time[other, me] >= 0
    }


def heard(make, state, pairs):
    """The state after a step in which (self, other) pairs were heard."""
    ears = np.zeros((6, 4), bool)
    for me, other in pairs:
        ears[other, me] = True
    return make.replace(state, heard=ears)


def test_nobody_knows_anything_at_first(make):
    assert table(make.state(make.arena(PLACES))) == {}


def test_those_heard_enter_with_place_and_time(make):
    arena = make.arena(PLACES)
    links = make.links(4, heard=[(0, 1), (0, 4), (2, 3), (3, 5)])
    state = make.enter(make.state(arena, t=7), links, arena, make.physics().radio)
    assert table(state) == {(0, 1): (7, 20, 2), (2, 3): (7, 40, 4)}
    np.testing.assert_array_equal(state.heard, links.heard)


def test_news_replaces_what_was_known_and_silence_keeps_it(make):
    arena = make.arena(PLACES)
    state = make.know(make.state(arena, t=9), {(0, 1): (3, -5, -6), (0, 2): (8, 7, 7), (1, 0): (2, 0, 0)})
    state = make.enter(state, make.links(4, heard=[(0, 1)]), arena, make.physics().radio)
    assert table(state) == {(0, 1): (9, 20, 2), (0, 2): (8, 7, 7), (1, 0): (2, 0, 0)}


def test_the_newest_news_wins(make):
    arena = make.arena(PLACES)
    state = make.know(
        make.state(arena, t=10),
        {(0, 3): (2, 1, 1), (1, 3): (5, 2, 2), (2, 3): (4, 3, 3), (0, 1): (10, 20, 2), (0, 2): (10, 30, 3)},
    )
    known = table(make.share(heard(make, state, [(0, 1), (0, 2)])))
    assert known[0, 3] == (5, 2, 2)
    assert known[1, 3] == (5, 2, 2)
    assert known[2, 3] == (4, 3, 3)


def test_older_news_is_not_taken(make):
    state = make.know(make.state(make.arena(PLACES)), {(0, 3): (9, 1, 1), (1, 3): (5, 2, 2)})
    assert table(make.share(heard(make, state, [(0, 1)])))[0, 3] == (9, 1, 1)


def test_nobody_learns_about_itself(make):
    state = make.know(make.state(make.arena(PLACES)), {(1, 0): (9, 1, 1)})
    assert table(make.share(heard(make, state, [(0, 1)]))) == {(1, 0): (9, 1, 1)}


def test_only_those_heard_tell(make):
    """Whom 0 hears tells 0; that 0 hears 1 tells 1 nothing."""
    state = make.know(make.state(make.arena(PLACES)), {(0, 2): (9, 1, 1), (1, 3): (9, 2, 2), (2, 1): (9, 3, 3)})
    known = table(make.share(heard(make, state, [(0, 1)])))
    assert known == {(0, 2): (9, 1, 1), (1, 3): (9, 2, 2), (2, 1): (9, 3, 3), (0, 3): (9, 2, 2)}


def test_everybody_shares_at_once(make):
    """What 1 learns from 2 in this exchange, 0 learns from 1 in the next only, in whatever order they stand."""
    state = make.know(make.state(make.arena(PLACES)), {(2, 3): (9, 1, 1)})
    for chain in ([(0, 1), (1, 2)], [(1, 0), (0, 2)]):
        first = make.share(heard(make, state, chain))
        last, middle = chain[0]
        assert (middle, 3) in table(first)
        assert (last, 3) not in table(first)
        assert (last, 3) in table(make.share(first))


def test_sharing_against_a_plain_merge_on_random_knowledge(make):
    rng = np.random.default_rng(1)
    for trial in range(30):
        entries = {
            (i, j): (int(rng.integers(0, 5)), float(10 * i + j), float(j))
            for i in range(4) for j in range(4) if i != j and rng.random() < 0.6
        }  # fmt: skip
        # the place of j at a time is the same whoever tells
        entries = {(i, j): (t, float(100 * j + t), float(j)) for (i, j), (t, _, _) in entries.items()}
        pairs = [(i, j) for i in range(4) for j in range(4) if i != j and rng.random() < 0.5]
        ranges = rng.choice([0, 30.0, 60.0, 90.0], 4)
        state = make.know(make.state(make.arena(PLACES), jammer_range=ranges), entries)
        shared = make.share(heard(make, state, pairs))
        expected = dict(entries)
        for me, teacher in pairs:
            for (who, other), news in entries.items():
                if who == teacher and other != me and news > expected.get((me, other), (-1,)):
                    expected[me, other] = news
        assert table(shared) == expected, trial
        told = [max([ranges[i], *(ranges[j] for me, j in pairs if me == i)]) for i in range(4)]
        np.testing.assert_array_equal(shared.jammer_range, np.float32(told))


@pytest.mark.parametrize("channel", [0, 1, 2])
def test_the_jammers_range_is_the_greatest_distance_at_which_it_was_received(make, channel):
    arena = make.arena(PLACES, jammer=(10, 101), channels=(0, 1, 2))
    radio = make.physics().radio

    def enter(state, powers):
        noise = np.zeros((3, 6), np.float32)
        noise[channel, :4] = np.array(powers) * P_RS
        return make.enter(state, make.links(4, heard=[], jamming=noise), arena, radio)

    first = enter(make.state(arena), [1.01, 0.99, 0, 100])
    distance = [np.hypot(10 - x, 101 - y) for x, y in PLACES]
    np.testing.assert_allclose(first.jammer_range, [distance[0], 0, 0, distance[3]], rtol=1e-6)
    moved = make.replace(first, node_x=first.node_x.at[0].set(10), node_y=first.node_y.at[0].set(50))
    np.testing.assert_allclose(enter(moved, [9, 9, 0, 0]).jammer_range, [100, distance[1], 0, distance[3]], rtol=1e-6)
    farther = make.replace(first, node_x=first.node_x.at[0].set(10), node_y=first.node_y.at[0].set(-49))
    np.testing.assert_allclose(enter(farther, [2, 0, 0, 0]).jammer_range[0], 150, rtol=1e-6)
    np.testing.assert_allclose(enter(farther, [0.9, 0, 0, 0]).jammer_range[0], 100, rtol=1e-6)


def test_the_jammers_range_is_shared_with_whoever_hears(make):
    state = make.state(make.arena(PLACES), jammer_range=[0, 70, 90, 0])
    np.testing.assert_array_equal(make.share(heard(make, state, [(0, 1), (1, 2)])).jammer_range, [70, 90, 90, 0])


def test_places_of_source_and_sink_stay_outside(make):
    """Hearing them enters nothing about agents, and K has no rows for them."""
    arena = make.arena(PLACES)
    state = make.enter(make.state(arena), make.links(4, heard=[(0, 4), (0, 5)]), arena, make.physics().radio)
    assert table(state) == {}
    assert state.known_time.shape == (4, 4)
