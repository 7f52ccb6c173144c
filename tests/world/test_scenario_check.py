"""Scenarios by hand: whatever cannot be computed is refused in one line that names the field."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config import InputError, Settings, Swarm, World
from slcs2_jax.config.jammers import MOST_JAMMERS
from slcs2_jax.world.scenario import Jammer, check_scenario, make_scenario

SETTINGS = Settings(world=World.preset("urban_jammed"), swarm=Swarm(agents=4))
GOOD = make_scenario(SETTINGS, 3)
NAN, INF = np.float32(np.nan), np.float32(np.inf)


def f32(*values):
    return np.array(values, np.float32)


def spoilt(array, value):
    array = array.copy()
    array.reshape(-1)[-1] = value
    return array


def jammer(**values):
    return (dataclasses.replace(GOOD.jammers[0], **values),)


CASES = {
    "sink is NaN": ("sink", f32(NAN, 0)),
    "sink is infinite": ("sink", f32(INF, 0)),
    "sink is too far": ("sink", f32(2e5, 0)),
    "two sinks": ("sink", f32([600, 0], [500, 0])),
    "sink in one dimension": ("sink", f32(600)),
    "sink in three": ("sink", f32(600, 0, 0)),
    "sink is a list": ("sink", [600.0, 0.0]),
    "sink is a text": ("sink", "600,0"),
    "no sink": ("sink", None),
    "sink in float64": ("sink", np.array([600.0, 0.0])),
    "sink in whole numbers": ("sink", np.array([600, 0])),
    "sink at the source": ("sink", f32(0, 0)),
    "estimate is NaN": ("sink_estimate", f32(600, NAN)),
    "estimate of another shape": ("sink_estimate", f32([600, 0])),
    "no estimate": ("sink_estimate", None),
    "a start is NaN": ("start", spoilt(GOOD.start, NAN)),
    "a start is infinite": ("start", spoilt(GOOD.start, -INF)),
    "a start is far away": ("start", spoilt(GOOD.start, 1e30)),
    "too few starts": ("start", GOOD.start[:3]),
    "too many starts": ("start", np.concatenate([GOOD.start, GOOD.start[:1] + 1])),
    "no starts": ("start", GOOD.start[:0]),
    "two agents at one place": ("start", GOOD.start[[0, 1, 2, 0]]),
    "starts in three dimensions": ("start", np.zeros((4, 3), np.float32)),
    "starts as objects": ("start", GOOD.start.astype(object)),
    "a wall is NaN": ("vertical", spoilt(GOOD.vertical, NAN)),
    "a wall is infinite": ("horizontal", spoilt(GOOD.horizontal, INF)),
    "walls with two columns": ("vertical", GOOD.vertical[:, :2]),
    "walls without rows": ("vertical", f32(1, 2, 3)),
    "a wall upside down": ("horizontal", f32([10, 5, -5])),
    "walls as a list": ("vertical", []),
    "far too many walls": ("vertical", np.zeros((30_000, 3), np.float32)),
    "walls of another thickness": ("wall_thickness", 2.0),
    "thickness is NaN": ("wall_thickness", float("nan")),
    "thickness is a text": ("wall_thickness", "1"),
    "time limit of 0": ("time_limit", 0),
    "time limit below 0": ("time_limit", -5),
    "time limit with a half": ("time_limit", 1.5),
    "time limit beyond int32": ("time_limit", 2**40),
    "time limit is true": ("time_limit", True),
    "no time limit": ("time_limit", None),
    "jammer is NaN": ("jammers", jammer(place=f32(NAN, 0))),
    "jammer in three dimensions": ("jammers", jammer(place=f32(1, 2, 3))),
    "two jammers in one": ("jammers", jammer(place=f32([1, 2], [3, 4]))),
    "jammers as an array": ("jammers", f32([1, 2], [3, 4])),
    "a jammer that is none": ("jammers", (f32(1, 2),)),
    "too many jammers": ("jammers", jammer() * (MOST_JAMMERS + 1)),
    "an emission that is none": ("jammers", jammer(emission="loud")),
    "a motion that is none": ("jammers", jammer(motion="sideways")),
    "a route that is NaN": ("jammers", jammer(motion="patrol", route=f32([NAN, 0]))),
    "a route of one point without a row": ("jammers", jammer(motion="patrol", route=f32(1, 0))),
    "a route without end": ("jammers", jammer(route=np.ones((40, 2), np.float32))),
    "a speed of 0": ("jammers", jammer(speed=0.0)),
    "a speed that is NaN": ("jammers", jammer(speed=float("nan"))),
    "a duty above 1": ("jammers", jammer(duty=1.5)),
    "half a step of dwell": ("jammers", jammer(dwell=0.5)),
    "power without bounds": ("jammers", jammer(power_db=1e9)),
    "environment is no text": ("environment", None),
    "seed is no number": ("seed", "3"),
    "seed below 0": ("seed", -1),
}


@pytest.mark.parametrize("case", CASES)
def test_what_cannot_be_computed_is_refused_by_field(case):
    field, value = CASES[case]
    with pytest.raises(InputError) as caught:
        check_scenario(dataclasses.replace(GOOD, **{field: value}), SETTINGS)
    message = str(caught.value)
    assert message.startswith(f"scenario.{field}"), message
    assert "accepted is" in message
    assert "\n" not in message
    assert len(message) < 300


@pytest.mark.parametrize("kind", ["open", "jammed", "urban", "urban_jammed"])
@pytest.mark.parametrize("reach", ["short", "long"])
def test_worlds_made_from_seeds_pass(kind, reach):
    settings = Settings(world=World.preset(kind, reach))
    for seed in range(5):
        check_scenario(make_scenario(settings, seed), settings)


def test_worlds_by_hand_that_make_sense_pass():
    other = dataclasses.replace(
        GOOD,
        vertical=GOOD.vertical[:0],
        time_limit=np.int32(7),
        jammers=(Jammer(f32(1, 2), emission="sweeping", motion="patrol", route=f32([4, 5], [6, 7])), *GOOD.jammers),
    )
    check_scenario(other, SETTINGS)
