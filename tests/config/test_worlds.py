"""Lists of worlds: what they say, in which order, and what is refused."""

from __future__ import annotations

import pytest

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.config import InputError
from slcs2_jax.config.worlds import home_of, worlds_of


def test_worlds_come_by_turns():
    settings = slcs2.Settings(worlds=("open/short/3..5", "urban_jammed/long/7", "jammed/0..1"))
    found = [(kind.name, its.world.environment, its.world.distance, seed) for kind, its, seed in worlds_of(settings)]
    assert found == [
        ("open/short", "open", 600.0, 3),
        ("urban_jammed/long", "urban_jammed", 1000.0, 7),
        ("jammed", "jammed", 600.0, 0),
        ("open/short", "open", 600.0, 4),
        ("jammed", "jammed", 600.0, 1),
        ("open/short", "open", 600.0, 5),
    ]
    assert home_of(settings, 99, 9)[1] == 4
    assert home_of(settings, 99, 9)[0] == slcs2.Settings()
    assert home_of(slcs2.Settings(), 99, 9) == (slcs2.Settings(), 99)


def test_an_entry_without_a_range_keeps_the_distance():
    settings = slcs2.Settings(world=slcs2.World(distance=190.0, time_limit=30), worlds=("urban/0", "open/long/0"))
    assert [(its.world.distance, its.world.time_limit) for _, its, _ in worlds_of(settings)] == [
        (190.0, 30),
        (1000.0, 40_000),
    ]


@pytest.mark.parametrize(
    ("worlds", "says"),
    [
        (["open/short/0..7/agents=8"], "accepted is a list of ENVIRONMENT/RANGE/SEEDS.*swarm.*are the run's own"),
        (["forest/short/0"], "accepted is environments open, jammed, urban, urban_jammed"),
        (["open/middle/0"], "accepted is ranges short, long"),
        (["open/short/7..3"], "accepted is seeds from a smaller to a greater one"),
        (["open/short/0..7", "open/short/7"], "open/short/7 is there twice"),
        (["open/short/0..2000"], "2001 worlds; accepted are at most 1000"),
        (["open/short/0..600", "jammed/short/0..600"], "1202 worlds; accepted are at most 1000"),
        ([3], "worlds=.*3.*: accepted is a list of texts"),
    ],
)
def test_what_is_refused(worlds, says):
    with pytest.raises(InputError, match=says) as caught:
        slcs2.Settings(worlds=tuple(worlds))
    assert "\n" not in str(caught.value)


def test_each_world_must_have_a_place_for_jammer_and_agents():
    with pytest.raises(InputError, match=r"world\.distance=190: no place for the jammer"):
        slcs2.Settings(world=slcs2.World(distance=190.0), worlds=("open/0", "jammed/0"))


def test_on_the_command_line(capfd):
    assert cli.main(["evolve", "--cfg", "job", "worlds=[open/short/0..7, jammed/short/0..7]"]) == 0
    assert "worlds:\n- open/short/0..7\n- jammed/short/0..7\n" in capfd.readouterr().out
    assert cli.main(["evolve", "worlds=[open/short/0..7, lunar/0]"]) == 2
    [line] = capfd.readouterr().err.splitlines()
    assert "worlds=lunar/0: accepted is environments open" in line
