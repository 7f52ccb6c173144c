"""Several jammers, of any kind: their links and powers, what they disturb, where they go, what agents know of them."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import Radio, Settings, Swarm
from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.swarm import jamming, knowledge
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.step import Physics
from slcs2_jax.world.arena import stack
from slcs2_jax.world.emitters import JammerRoom
from slcs2_jax.world.scenario import Jammer, Scenario

PLACES = ((100, 0), (130, 20), (250, -30))
EVERY = ("constant", "random", "reactive", "sweeping"), ("fixed", "patrol", "pursue")
ROOM = JammerRoom(4, 3, *EVERY)


def f32(*values):
    return np.array(values, np.float32)


def world(*jammers, channels=(0,), room=ROOM, time_limit=1000):
    """Worlds with the same room share a program."""
    scenario = Scenario(
        environment="by hand",
        seed=0,
        sink=f32(600, 0),
        sink_estimate=f32(600, 0),
        jammers=jammers,
        vertical=np.zeros((0, 3), np.float32),
        horizontal=np.zeros((0, 3), np.float32),
        wall_thickness=1.0,
        start=np.array(PLACES, np.float32),
        time_limit=time_limit,
    )
    stacked = stack([scenario], [channels], capacity=(0, 0), width=3, jammers=room)
    return jax.tree.map(lambda leaf: jnp.asarray(leaf[..., 0]), stacked)


def physics(fading="none", **settings):
    return Physics.of(Settings(radio=Radio(fading=fading, **settings), swarm=Swarm(agents=len(PLACES))))


KEY = jnp.array([5, 6], jnp.uint32)
begin = jax.jit(swarm.begin)
observe = jax.jit(swarm.observe)


STEPS = 40


@jax.jit
def idle(arena, parameters):
    """Nobody acts: the states after 0 to 39 steps, and the links of each."""

    def one(state, _):
        state, seen = swarm.observe(state, arena, parameters)
        after, _, _ = swarm.act(jnp.full(state.x.shape, np.int32(NO_ACTION)), seen, parameters)
        return after, (state, seen.view.links)

    return jax.lax.scan(one, swarm.begin(arena, KEY, parameters), length=STEPS)[1]


def mean_mw(distance, power_db=0.0):
    return 10 ** ((20 + power_db - 40.05 - 28 * np.log10(distance)) / 10)


def test_the_general_way_gives_the_papers_jammer_bit_by_bit():
    plain = Jammer(f32(150, 40))
    for channels in ((0,), (0, 1, 2)):
        one, other = (idle(world(plain, channels=channels, room=room), physics("lognormal")) for room in (None, ROOM))
        assert one[1].jamming.max() > 0
        assert one[0].jammer_range.max() > 0
        for name in ("power", "jamming", "heard"):
            np.testing.assert_array_equal(getattr(one[1], name), getattr(other[1], name), err_msg=name)
        for field in dataclasses.fields(one[0]):
            if field.name not in ("jammers", "down", "lost"):
                was, found = getattr(one[0], field.name), getattr(other[0], field.name)
                np.testing.assert_array_equal(was, found, err_msg=field.name)


def test_powers_add_up():
    at = {(150, 40): 0, (90, -60): -7, (0, 300): 5}
    jammers = [Jammer(f32(*place), "constant", power_db=db) for place, db in at.items()]
    _, drawn = idle(world(*jammers), physics())
    nodes = [*PLACES, (0, 0), (600, 0)]
    expected = [sum(mean_mw(np.hypot(*(np.array(node) - j.place)), j.power_db) for j in jammers) for node in nodes]
    np.testing.assert_allclose(drawn.jamming[0, 0], expected, rtol=1e-4)


def test_a_jammer_disturbs_the_channel_that_it_is_on():
    jammers = [Jammer(f32(150, 40), emission="sweeping", dwell=5), Jammer(f32(160, 40), emission="sweeping", dwell=5)]
    _, drawn = idle(world(*jammers, channels=(0, 1, 2)), physics())
    for step, (first, second) in enumerate(((0, 1), (1, 2), (2, 0), (0, 1))):
        for t in range(5 * step, 5 * step + 5):
            assert drawn.jammers.channel[t].tolist() == [first, second, -1, -1]
            assert (drawn.jamming[t, [first, second]] > 0).all()
            assert (np.delete(drawn.jamming[t], [first, second], axis=0) == 0).all()
    assert drawn.heard[:, 1, 0].all()  # one channel is always free


def test_constant_jammers_on_the_one_channel_silence_it_until_they_are_gone():
    near = Jammer(f32(115, 10), emission="constant")
    assert not idle(world(near), physics())[1].heard[0, 1, 0]
    assert idle(world(dataclasses.replace(near, emission="random", duty=0.0)), physics())[1].heard[0, 1, 0]
    assert idle(world(near, channels=(0, 1)), physics())[1].heard[0, 1, 0]


def test_a_link_is_drawn_by_its_names_whatever_room_there_is():
    jammers = [Jammer(f32(150, 40), "constant"), Jammer(f32(90, -60), "constant")]
    for fading in ("nakagami",):
        tight = idle(world(*jammers, room=JammerRoom(2, 1, ("constant",), ("fixed",))), physics(fading))[1]
        wide = idle(world(*jammers), physics(fading))[1]
        np.testing.assert_array_equal(tight.jamming, wide.jamming)
        np.testing.assert_array_equal(tight.jammers.noise, wide.jammers.noise[:, :2])
        third = idle(world(*jammers, Jammer(f32(0, 200), "constant")), physics(fading))[1]
        np.testing.assert_array_equal(tight.jammers.noise, third.jammers.noise[:, :2])
        np.testing.assert_array_equal(tight.power, third.power)


def test_links_of_different_jammers_and_nodes_are_independent():
    here = f32(150, 40)
    noise = idle(world(*[Jammer(here, "constant")] * 4), physics("lognormal"))[1].jammers.noise
    table = np.log(np.asarray(noise)).reshape(STEPS, -1)  # four jammers, five nodes
    close = np.abs(np.corrcoef(table.T)[~np.eye(20, dtype=bool)])
    assert close.max() < 4.5 / np.sqrt(STEPS)
    assert len(np.unique(table)) > table.size - 5


def test_every_jammer_moves_as_it_should():
    patrol = Jammer(f32(300, 0), motion="patrol", route=f32([300, 30], [340, 30]), speed=4.0)
    hunter = Jammer(f32(150, 80), motion="pursue", speed=1.5)
    state, _ = idle(world(hunter, patrol, Jammer(f32(9, 9))), physics())
    x, y = jax.vmap(jamming.places)(state)
    np.testing.assert_allclose(x[:3, 1], [300, 300, 300])
    np.testing.assert_allclose(y[:3, 1], [0, 4, 8], atol=1e-4)
    assert (x[:, 2] == 9).all()
    steps = np.hypot(np.diff(x[:, 0]), np.diff(y[:, 0]))
    np.testing.assert_allclose(steps, 1.5, atol=1e-3)
    away = np.hypot(x[:, 0] - 130, y[:, 0] - 20)  # the second agent is the nearest
    assert (np.diff(away) < 0).all()


def test_nothing_moves_once_the_episode_is_over():
    state, _ = idle(world(Jammer(f32(150, 80), motion="pursue"), time_limit=3), physics())
    assert state.t[-1] == 3
    assert (state.node_x[3:, -1] == state.node_x[3, -1]).all()
    assert state.node_x[2, -1] != state.node_x[3, -1]


def test_agents_know_the_nearest_jammer_that_they_noticed_where_they_last_noticed_it():
    near = Jammer(f32(150, 40), "constant")
    far = Jammer(f32(220, -60), "constant", motion="patrol", route=f32([220, 3000]), speed=100.0)
    state, _ = idle(world(far, near), physics())
    x, y = (np.asarray(a) for a in jax.vmap(jamming.places)(state))
    for agent, at in enumerate(PLACES):
        away = np.hypot(x - at[0], y - at[1])
        heard = mean_mw(away) >= 10**-8.2
        for jammer in range(2):
            seen = np.flatnonzero(heard[:, jammer])
            last = seen.max()
            assert state.jammers.seen_time[-1, jammer, agent] == last
            assert state.jammers.seen_y[-1, jammer, agent] == y[last, jammer]
            np.testing.assert_allclose(state.jammers.seen_range[-1, jammer, agent], away[seen, jammer].max(), rtol=1e-5)
        known = [
            (float(state.jammers.seen_x[-1, j, agent]), float(state.jammers.seen_y[-1, j, agent])) for j in range(2)
        ]
        nearest = min((0, 1), key=lambda j: np.hypot(known[j][0] - at[0], known[j][1] - at[1]))
        assert state.jammer_range[-1, agent] == state.jammers.seen_range[-1, nearest, agent]
        last = jax.tree.map(lambda leaf: leaf[-1], state)
        bx, by = jamming.believed(last, None)
        assert (float(bx[agent]), float(by[agent])) == known[nearest]


def test_sharing_takes_the_newest_place_and_the_greatest_range():
    arena = world(Jammer(f32(150, 40)), Jammer(f32(90, -60)))
    state = begin(arena, KEY, physics())
    state, _ = observe(state, arena, physics())
    unknown = -np.ones((4, 3), np.int32)
    time, x, reach = unknown.copy(), np.zeros((4, 3), np.float32), np.zeros((4, 3), np.float32)
    time[0], x[0], reach[0] = [7, 9, -1], [70, 90, 0], [50, 20, 0]
    heard = np.zeros((5, 3), bool)
    heard[0, 2] = heard[1, 2] = heard[1, 0] = True  # the third hears both, the first the second
    known = dataclasses.replace(
        state.jammers, seen_time=jnp.array(time), seen_x=jnp.array(x), seen_y=jnp.array(x), seen_range=jnp.array(reach)
    )
    state = dataclasses.replace(state, jammers=known, heard=jnp.array(heard))
    after = knowledge.share(state).jammers
    assert after.seen_time[0].tolist() == [9, 9, 9]
    assert after.seen_x[0].tolist() == [90, 90, 90]
    assert after.seen_range[0].tolist() == [50, 20, 50]
    assert (after.seen_time[1:] == -1).all()
    assert (after.seen_range[1:] == 0).all()


@pytest.mark.parametrize("fading", ["none", "rayleigh", "rician", "nakagami"])
def test_links_fade_as_they_are_told_and_alike_in_both_directions(fading):
    _, drawn = idle(world(room=None), physics(fading, rician_k=2.0, nakagami_m=1.7))
    power = np.asarray(drawn.power, float)
    np.testing.assert_array_equal(power, np.swapaxes(power, 1, 2))
    nodes = np.array([*PLACES, (0, 0), (600, 0)], float)
    one, other = np.triu_indices(5, 1)
    gain = power[:, one, other] / mean_mw(np.hypot(*(nodes[one] - nodes[other]).T))
    spread = {"none": 0, "rayleigh": 1, "rician": 5 / 9, "nakagami": 1 / 1.7}[fading]
    assert gain.mean() == pytest.approx(1, abs=1e-3 + 5 * np.sqrt(spread / gain.size))
    assert gain.var() == pytest.approx(spread, abs=1e-3 + 0.5 * spread)
