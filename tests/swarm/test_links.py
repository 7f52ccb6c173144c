"""Powers between all nodes, the jammer's answer and its channel, and who hears whom."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
import shapely
from scipy import special

from slcs2_jax.world import randomness

NET = 163.0  # m, nearly: the range without shadowing
QUIET = {"shadowing_db": 0.0}


def db(power):
    return 10 * np.log10(np.asarray(power, np.float64))


def deviate(key, t, number):
    word = randomness.bits(
        randomness.stream(jnp.array(key, jnp.uint32), jnp.int32(t), randomness.Purpose.SHADOWING), jnp.uint32(number)
    )
    return special.ndtri(((int(word) >> 8) + 0.5) / 2**24)


def expected_dbm(nodes, walls, key, t, pairs, *, sigma=4.0, loss=2.0):
    """Model section 3 word for word, one link at a time, for nodes [n + 3, 2]."""
    count = len(nodes)
    for u, v in pairs:
        d = max(np.hypot(*(nodes[u] - nodes[v])), 1.0)
        link = shapely.LineString([nodes[u], nodes[v]])
        crossed = sum(link.crosses(wall) for wall in walls)
        number = min(u, v) * count + max(u, v)
        yield 20 - 40.05 - 28 * np.log10(d) - loss * crossed + sigma * deviate(key, t, number)


@pytest.mark.parametrize("n", [2, 5, 6])
def test_every_power_is_the_specifications(make, n):
    rng = np.random.default_rng(n)
    places = rng.uniform(-60, 60, (n, 2)).astype(np.float32)
    vertical = [(x, -40, 40) for x in (-20.5, 5.5, 31.5)]
    horizontal = [(y, -30, 50) for y in (-15.5, 22.5)]
    walls = [shapely.LineString([(x, a), (x, b)]) for x, a, b in vertical]
    walls += [shapely.LineString([(a, y), (b, y)]) for y, a, b in horizontal]
    arena = make.arena(places, sink=(90, 10), jammer=(40, -70), vertical=vertical, horizontal=horizontal)
    key, t = (11, 4_000_000_000), 17
    links = make.measure(make.state(arena, key=key, t=t), arena, make.physics().radio)
    nodes = np.concatenate([places, [[0, 0], [90, 10], [40, -70]]]).astype(float)
    pairs = [(u, v) for u in range(n + 2) for v in range(u + 1, n + 2)]
    got = [db(links.power[u, v]) for u, v in pairs]
    np.testing.assert_allclose(got, list(expected_dbm(nodes, walls, key, t, pairs)), atol=2e-3)
    at_jammer = [(v, n + 2) for v in range(n + 2)]
    jam = list(expected_dbm(nodes, walls, key, t, at_jammer))
    assert max(jam) > -82
    np.testing.assert_allclose(db(links.jamming[0]), jam, atol=2e-3)


def test_links_are_reciprocal_and_nobody_links_to_itself(make):
    arena = make.arena(np.random.default_rng(0).uniform(-50, 50, (6, 2)))
    for t in range(3):
        power = np.asarray(make.measure(make.state(arena, t=t), arena, make.physics().radio).power)
        np.testing.assert_array_equal(power, power.T)
        assert (np.diag(power) == 0).all()
        assert (power[~np.eye(8, dtype=bool)] > 0).all()


def test_shadowing_is_drawn_anew_for_every_link_step_and_episode(make):
    arena = make.arena([(10, 0), (0, 10), (-10, 0), (0, -10)], sink=(600, 0))
    radio = make.physics().radio
    seen = [np.asarray(make.measure(make.state(arena, t=t, key=key), arena, radio).power)
            for key in ((1, 2), (1, 3), (2, 2)) for t in range(3)]  # fmt: skip
    to_source = np.array([p[:4, 4] for p in seen])  # all at 10 m
    assert len(np.unique(to_source)) == to_source.size


def test_shadowing_has_its_deviation(make):
    arena = make.arena(np.random.default_rng(0).uniform(-50, 50, (6, 2)))
    radio, flat = make.physics().radio, make.physics(radio=QUIET).radio
    upper = np.triu_indices(8, 1)
    mean = db(np.asarray(make.measure(make.state(arena), arena, flat).power)[upper])
    off = np.concatenate(
        [db(np.asarray(make.measure(make.state(arena, t=t), arena, radio).power)[upper]) - mean for t in range(150)]
    )
    assert off.mean() == pytest.approx(0, abs=5 * 4 / np.sqrt(off.size))
    assert off.std() == pytest.approx(4, rel=0.05)


def test_hearing_ends_at_the_network_range(make):
    """Without shadowing: 160 m is heard, 166 m is not; source and sink are heard as well."""
    arena = make.arena([(100, 0), (260, 0), (266, 0), (-500, 0)], sink=(420, 0))
    heard = np.asarray(make.measure(make.state(arena), arena, make.physics(radio=QUIET).radio).heard)
    assert heard[1, 0]
    assert heard[0, 1]
    assert not heard[2, 0]
    assert heard[4, 0]  # the source, 100 m away
    assert not heard[4, 1]
    assert heard[5, 1]  # the sink, 160 m away
    assert not heard[5, 0]
    assert not heard[:, 3].any()
    assert not heard[3].any()


def test_nobody_hears_itself(make):
    arena = make.arena(np.random.default_rng(0).uniform(-5, 5, (6, 2)))
    heard = np.asarray(make.measure(make.state(arena), arena, make.physics().radio).heard)
    np.testing.assert_array_equal(heard[:6], ~np.eye(6, dtype=bool))


def test_walls_end_hearing(make):
    """158 m leave 0.4 dB: one wall of 2 dB is too much."""
    places = [(0, 10), (158, 10), (0, 60), (158, 60)]
    arena = make.arena(places, vertical=[(80, 0, 20)])
    heard = np.asarray(make.measure(make.state(arena), arena, make.physics(radio=QUIET).radio).heard)
    assert not heard[1, 0]
    assert heard[3, 2]


def jammed(make, places, jammer, channels=(0,), width=3, **options):
    arena = make.arena(places, jammer=jammer, channels=channels, width=width, **options)
    return make.measure(make.state(arena), arena, make.physics(radio=QUIET).radio)


def test_the_jammer_answers_only_if_it_hears_a_beacon(make):
    far = jammed(make, [(0, 10), (20, 10)], (300, 0))
    assert (np.asarray(far.jamming) == 0).all()
    near = jammed(make, [(0, 10), (140, 10)], (300, 0))  # 160 m
    assert (np.asarray(near.jamming)[0] > 0).all()


@pytest.mark.parametrize("node", ["source", "sink"])
def test_the_jammer_hears_source_and_sink_too(make, node):
    away = [(-2000, 0), (-2000, 50)]
    place = (100, 0) if node == "source" else (550, 0)
    assert (np.asarray(jammed(make, away, place).jamming)[0] > 0).all()
    assert (np.asarray(jammed(make, away, (300, 0)).jamming) == 0).all()


def test_a_world_without_a_jammer_is_never_jammed(make):
    arena = make.arena([(0, 10), (20, 10)])
    assert (np.asarray(make.measure(make.state(arena), arena, make.physics().radio).jamming) == 0).all()


@pytest.mark.parametrize(
    ("channels", "first"), [((0,), 0), ((0, 1, 2), 0), ((1,), 1), ((2,), 2), ((1, 2), 1), ((0, 2), 0)]
)
def test_the_jammer_jams_the_first_channel_in_use_at_full_power(make, channels, first):
    links = jammed(make, [(200, 10), (220, 10)], (250, 10), channels)
    jamming = np.asarray(links.jamming)
    assert (np.delete(jamming, first, axis=0) == 0).all()
    distance = np.array([50, 30, np.hypot(250, 10), np.hypot(350, 10)])
    np.testing.assert_allclose(db(jamming[first]), 20 - 40.05 - 28 * np.log10(distance), atol=1e-3)


@pytest.mark.parametrize("channels", [(0,), (1,), (2,)])
def test_on_a_single_channel_nothing_is_heard_near_the_jammer(make, channels):
    heard = np.asarray(jammed(make, [(200, 10), (220, 10)], (210, 20), channels).heard)
    assert not heard.any()


@pytest.mark.parametrize("channels", [(0, 1), (0, 1, 2), (1, 2), (0, 2)])
def test_beacons_escape_to_another_channel(make, channels):
    heard = np.asarray(jammed(make, [(200, 10), (220, 10)], (210, 20), channels).heard)
    assert heard[1, 0]
    assert heard[0, 1]


def test_a_jammed_agent_still_hears_whoever_is_much_nearer_than_the_jammer(make):
    """10 dB ask for a distance 10^(10/28) = 2.28 times smaller."""
    heard = np.asarray(jammed(make, [(100, 0), (110, 0), (140, 0)], (160, 0)).heard)
    assert heard[1, 0]  # 10 m against 60 m
    assert not heard[2, 0]  # 40 m against 60 m
    assert not heard[1, 2]  # 30 m against 20 m
    assert not heard[3, 0]  # the source, 100 m


def test_hearing_is_power_and_ratio_on_random_worlds(make):
    rng = np.random.default_rng(4)
    radio = make.physics().radio
    noise = 10**-9.4
    fractions = []
    for trial in range(40):
        channels = [(0,), (0, 1, 2), (1, 2), (2,)][trial % 4]
        arena = make.arena(
            rng.uniform(-100, 300, (6, 2)), sink=(300, 0), jammer=rng.uniform(0, 300, 2), channels=channels, width=3
        )
        links = make.measure(make.state(arena, t=trial), arena, radio)
        power, jamming = np.asarray(links.power, float), np.asarray(links.jamming, float)
        sinr = np.stack([power[:, :6] / (noise + jamming[c, :6]) for c in channels]).max(axis=0)
        expected = (power[:, :6] >= 10**-8.2) & (sinr >= 10)
        unsure = (np.abs(db(power[:, :6] + 1e-30) + 82) < 1e-3) | (np.abs(db(sinr + 1e-30) - 10) < 1e-3)
        np.testing.assert_array_equal(np.asarray(links.heard)[~unsure], expected[~unsure])
        fractions.append(expected.mean())
    assert 0.05 < np.mean(fractions) < 0.9
