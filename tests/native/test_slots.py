"""Slots of the native chunk: episodes move together, and nothing that they come to changes."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest

from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.native import advance as native
from slcs2_jax.native import library
from slcs2_jax.native.slots import NativeSlots, groups_for
from slcs2_jax.policy.first_match import FirstMatch
from tests.native.episodes import BATCH, jitted, leaves, make

PERIODS = 3


@pytest.mark.parametrize(
    ("episodes", "threads", "groups"),
    [(0, 2, 0), (1, 2, 1), (4, 2, 1), (5, 2, 2), (16, 2, 2), (17, 2, 4), (33, 2, 6), (24, 8, 6), (40, 8, 8), (9, 1, 2)],
)
def test_groups_are_few_and_as_many_for_each_thread(episodes: int, threads: int, groups: int) -> None:
    assert groups_for(episodes, threads, 8) == groups


class Slots:
    """Native slots, and episodes for them: those of a batch as deployed, one in each place."""

    def __init__(self, episode: Episode, parameters: Parameters, *, threads: int) -> None:
        self.episode: Episode = jax.tree.map(np.asarray, episode)
        vacant = jax.tree.map(np.zeros_like, (self.episode.arena, self.episode.given))
        self.slots = NativeSlots(parameters, *vacant, periods=PERIODS, threads=threads)

    def place(self, slot: int, number: int) -> None:
        one = jax.tree.map(lambda leaf: leaf[..., number : number + 1], self.episode)
        key = one.state.key[:, 0]
        self.slots.place(slot, one.arena, jax.tree.map(lambda leaf: leaf[..., 0], one.given), (key[0], key[1]))

    def held(self, slot: int) -> Episode:
        return jax.tree.map(lambda leaf: leaf[..., self.slots._columns[slot]], self.slots._episode)

    def loads(self) -> list[int]:
        used = self.slots._columns[self.slots._columns >= 0] // library.lanes()
        return sorted(np.bincount(used).tolist(), reverse=True)


def same(found: Any, expected: Any) -> None:
    want = leaves(expected)
    for name, leaf in leaves(found).items():
        np.testing.assert_array_equal(leaf, want[name], err_msg=name)


@pytest.mark.parametrize("policy", [None, FirstMatch()])
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_an_episode_is_the_same_wherever_and_beside_whom_it_is_moved(threads: int, policy: Any) -> None:
    episode, parameters = make("urban_jammed", "both", policy=policy)
    expected = jitted(native.advance)(episode, parameters, 2 * PERIODS)
    slots = Slots(episode, parameters, threads=threads)
    for slot in range(BATCH - 1, -1, -1):
        slots.place(slot, slot)
    assert slots.slots.advance() == []
    for slot in range(0, BATCH, 3):
        slots.slots.cancel(slot)
    assert slots.slots.advance() == []
    columns = slots.slots._columns[slots.slots._columns >= 0]
    assert set(np.flatnonzero(slots.slots._episode.arena.time_limit)) == {*columns.tolist()}  # the rest costs nothing
    for slot in set(range(BATCH)) - set(range(0, BATCH, 3)):
        one = jax.tree.map(lambda leaf, slot=slot: leaf[..., slot], expected)
        same((slots.held(slot).state, slots.held(slot).memory), (one.state, one.memory))


def test_few_episodes_share_a_group_and_more_are_spread_evenly() -> None:
    slots = Slots(*make("open", "main"), threads=2)
    assert slots.slots.advance() == []
    assert slots.slots.computed == 0
    lanes = library.lanes()
    for count, loads in ((1, [1]), (3, [3]), (7, [4, 3]), (12, [6, 6])):
        for slot in range(count):
            if slots.slots._columns[slot] < 0:
                slots.place(slot, slot)
        slots.slots.advance()
        assert slots.loads()[: len(loads)] == loads
        assert slots.slots.computed == lanes * len(loads)
    for slot in range(2, 12):
        slots.slots.cancel(slot)
    slots.slots.advance()
    assert slots.slots.computed == lanes


def test_results_are_those_of_the_definition_and_vacate_their_slots() -> None:
    episode, parameters = make("open", "main", time_limit=PERIODS * 10)
    end = jitted(native.advance)(episode, parameters, PERIODS)
    expected = jax.jit(native.result)(end, parameters)
    slots = Slots(episode, parameters, threads=2)
    for slot in range(BATCH):
        slots.place(slot, slot)
    assert slots.slots.advance() == list(range(BATCH))
    chosen = [5, 0, 9]
    found = slots.slots.results(chosen)
    same(found, jax.tree.map(lambda leaf: leaf[..., np.array(chosen)], expected))
    assert np.flatnonzero(slots.slots._columns < 0).tolist() == sorted(chosen)


def test_room_is_that_of_all_threads_or_more_if_more_is_certain() -> None:
    slots = Slots(*make("open", "main"), threads=1).slots
    assert [slots.room(certain) for certain in (0, 1, library.lanes(), library.lanes() + 1, 99)] == [8, 8, 8, 16, 16]


@pytest.mark.parametrize("quality", [0.0, 2.5])
def test_episodes_of_numpy_arrays_begin_as_those_of_jax(quality: float) -> None:
    episode, parameters = make("urban_jammed", "both", learning={"initial_quality": quality})
    given = jax.tree.map(np.asarray, (episode.arena, episode.given, episode.state.key))
    found = native.begin(*given, jax.tree.map(np.asarray, parameters))
    assert all(isinstance(leaf, np.ndarray) for leaf in jax.tree.leaves(found))
    same(found, episode)
    assert dataclasses.replace(found, given=None).memory.quality.max() == np.float32(quality)


VALUES: tuple[dict[str, Any], ...] = (
    {},
    {"radio": {"path_loss_exponent": 3.2, "noise_dbm": -90.0, "shadowing_db": 7.0, "wall_loss_db": 5.0}},
    {"speed": 2.5, "packets": 3, "lidar_range": 25.0, "distance_threshold": 20.0, "tolerance": 0.2},
    {"learning": {"alpha_q": 0.9, "alpha_q_final": 0.1, "beta_q": 0.2, "alpha_grasp": 0.8, "trace_decay": 0.5}},
    {"clearance": 1.0, "learning": {"initial_quality": 2.0, "cost_move": 3.0, "cost_communicate": 1.0}},
    {"radio": {"half_power_db": -9.0, "receive_threshold_dbm": -70.0, "sinr_threshold_db": 3.0, "power_dbm": 26.0}},
)


@pytest.mark.parametrize("policy", [None, FirstMatch()])
def test_episodes_with_values_of_their_own_come_to_what_each_comes_to_without_the_others(policy: Any) -> None:
    made = [make("urban_jammed", "both", policy=policy, time_limit=PERIODS * 20, **values) for values in VALUES]
    expected = [jitted(native.advance)(*one, PERIODS) for one in made]
    ended = [jax.jit(native.result)(jitted(native.advance)(*one, 2 * PERIODS), one[1]) for one in made]
    differing = {leaves(state)[".state.node_x"].tobytes() for state in expected}
    assert len(differing) > 2
    slots = Slots(*made[0], threads=2)
    for slot in range(BATCH):
        one, parameters = jax.tree.map(np.asarray, made[slot % len(VALUES)])
        deployed = jax.tree.map(lambda leaf, slot=slot: leaf[..., slot : slot + 1], one)
        given = jax.tree.map(lambda leaf: leaf[..., 0], deployed.given)
        slots.slots.place(slot, deployed.arena, given, tuple(deployed.state.key[:, 0]), parameters)
    over = set(slots.slots.advance())
    for slot in set(range(BATCH)) - over:
        one = jax.tree.map(lambda leaf, slot=slot: leaf[..., slot], expected[slot % len(VALUES)])
        same((slots.held(slot).state, slots.held(slot).memory), (one.state, one.memory))
    slots.slots.cancel(3)
    over = sorted(over | set(slots.slots.advance()))
    assert over == [slot for slot in range(BATCH) if slot != 3]
    found = slots.slots.results(over)
    for place, slot in enumerate(over):
        one = jax.tree.map(lambda leaf, slot=slot: leaf[..., slot], ended[slot % len(VALUES)])
        same(jax.tree.map(lambda leaf, place=place: leaf[..., place], found), one)
