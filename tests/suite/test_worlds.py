"""The frozen worlds: what the suite promises of them, and that another world is refused."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.field import described
from slcs2_jax.config.settings import SECTIONS
from slcs2_jax.suite.worlds import SPLITS, load_suite, seeds_of
from tests.suite.conftest import small

PAPERS = [f"{kind}_{span}" for kind in ("open", "jammed", "urban", "urban_jammed") for span in ("short", "long")]


def test_the_papers_eight_worlds_and_ten_or_more_beyond():
    names = set(load_suite().worlds)
    assert set(PAPERS) <= names
    assert len(names) >= 18


@pytest.mark.parametrize("name", load_suite().worlds)
def test_every_world_is_the_published_one(name):
    load_suite().worlds[name].check()


def test_seeds_are_disjoint_and_those_of_no_experiment():
    suite = load_suite()
    every = [seed for world in suite.worlds.values() for split in SPLITS for seed in world.seeds_of(split)]
    assert len(set(every)) == len(every)
    assert min(every) >= 5_000_000
    assert all(len(world.seeds_of("test")) >= 30 for world in suite.worlds.values())
    assert all(len(world.seeds_of("train")) >= world.trainings for world in suite.worlds.values())
    assert all(suite.worlds[name].trainings >= (5 if name in PAPERS else 3) for name in suite.worlds)


@pytest.mark.parametrize("name", PAPERS)
def test_the_papers_worlds_have_the_papers_settings(name):
    """Of everything that decides; the published values are written down in the suite, and these are the defaults."""
    settings, usual = load_suite().worlds[name].settings(5_000_000), Settings()
    for section in ("radio", "swarm", "jammers", "task"):
        assert getattr(settings, section) == getattr(usual, section)
    kind, _, span = name.rpartition("_")
    assert settings.world == type(usual.world).preset(kind, span)


def test_nothing_that_decides_is_left_to_a_default():
    stated = set(load_suite().worlds["open_short"].stated)
    for section in ("radio", "swarm", "jammers", "task"):
        assert {f"{section}.{field.attribute}" for field in described(SECTIONS[section])} <= stated
    world = {f"world.{field.attribute}" for field in described(SECTIONS["world"])}
    assert world - stated == {"world.file", "world.content"}


def test_towns_from_files_differ_between_the_splits():
    world = load_suite().worlds["manhattan"]
    names = list(itertools.chain(*(world.files[split] for split in SPLITS)))
    assert len(set(names)) == len(names)
    walls = {world.scenario(seed).vertical.tobytes() for seed in world.seeds_of("test")}
    assert len(walls) == len(world.files["test"])
    for seed in (*world.seeds_of("train")[:3], *world.seeds_of("test")[:5]):
        scenario = world.scenario(seed)
        assert len(scenario.vertical) > 10
        assert np.abs(scenario.start).max() <= 50
        near = scenario.vertical[:, 0]
        assert near.min() > 50  # nobody starts inside a closed block


def test_a_changed_world_is_refused_by_name(tiny):
    world = tiny.worlds["few"]
    world.check()
    changed = dataclasses.replace(world, stated={**world.stated, "radio.noise_dbm": -93.9})
    with pytest.raises(InputError, match=r"world few of suite-v1: its checksum is .* accepted is"):
        changed.check()


@pytest.mark.parametrize(
    "stated", [{"swarm.speed": 2.5}, {"world.start_radius": 49.0}, {"world.time_limit": 601}, {"swarm.sink_error": 1.0}]
)
def test_whatever_decides_is_in_the_checksum(tiny, stated):
    world = load_suite().worlds["few"]
    assert small(world, **stated).sha256 != small(world).sha256


def test_a_seed_of_no_split_is_refused(tiny):
    with pytest.raises(InputError, match="seed=7: accepted is one of"):
        tiny.worlds["few"].split_of(7)
    with pytest.raises(InputError, match="seeds=4: accepted is a whole number from 1 to 3"):
        seeds_of(tiny.worlds["few"], "test", 4)
    with pytest.raises(InputError, match="world=nowhere: accepted is one of open_short, few"):
        tiny.chosen("few,nowhere")
