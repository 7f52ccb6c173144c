"""Worlds in files: what they may say, what is refused and how, and the way there and back."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from slcs2_jax.config import InputError, Jammers, Settings, Swarm, World
from slcs2_jax.config.world_text import LARGEST, by_path, read_world, with_world_text
from slcs2_jax.world.scenario import make_scenario
from slcs2_jax.world.world_file import scenario_text


def said(text, seed=1, agents=3):
    world = World(file="my.yaml", content=text)
    return make_scenario(Settings(world=world, swarm=Swarm(agents=agents)), seed)


def fields(scenario):
    values = {f.name: getattr(scenario, f.name) for f in dataclasses.fields(scenario)}
    jammers = values.pop("jammers")
    for number, jammer in enumerate(jammers):
        values |= {f"jammer {number} {f.name}": getattr(jammer, f.name) for f in dataclasses.fields(jammer)}
    return values


@pytest.mark.parametrize("kind", ["open", "jammed", "urban", "urban_jammed"])
def test_there_and_back_it_is_the_same_world(kind, tmp_path):
    jammers = Jammers(count=3, motion="patrol", emission="random", duty=0.3, patrol_points=4)
    settings = Settings(world=World.preset(kind), jammers=jammers, swarm=Swarm(sink_error=4.0))
    made = make_scenario(settings, 9)
    file = tmp_path / f"{kind}.yaml"
    file.write_text(scenario_text(made))
    again = make_scenario(dataclasses.replace(settings, world=World.from_file(file)), 9)
    assert fields(made).keys() == fields(again).keys()
    for name, value in fields(made).items():
        np.testing.assert_array_equal(value, fields(again)[name], err_msg=name)


def test_little_is_needed_and_the_rest_is_the_settings():
    made = said("sink: [300, 40]", seed=5)
    assert (made.environment, made.seed, made.time_limit) == ("my", 5, 20_000)
    assert made.sink.tolist() == made.sink_estimate.tolist() == [300, 40]
    assert made.walls == len(made.jammers) == 0
    assert made.start.shape == (3, 2)
    np.testing.assert_array_equal(made.start, said("sink: [300, 40]", seed=5).start)
    assert not np.array_equal(made.start, said("sink: [300, 40]", seed=6).start)


def test_everything_is_moved_with_the_source():
    made = said(
        "{source: [100, 10], sink: [400, 10], time_limit: 50, sink_estimate: [390, 20],"
        " walls: [{from: [150, 0], to: [150, -20]}, {from: [120, 5], to: [180, 5]},"
        " {corner: [200, 0], opposite: [230, 30]}],"
        " jammers: [{place: [300, 60], emission: sweeping, motion: patrol, route: [[310, 60], [310, 70]], speed: 3,"
        " dwell: 4}],"
        " starts: [[100, 20], [110, 10], [90, 10]]}"
    )
    assert made.sink.tolist() == [300, 0]
    assert made.sink_estimate.tolist() == [290, 10]
    assert made.time_limit == 50
    assert made.vertical.tolist() == [[50, -30, -10], [100, -10, 20], [130, -10, 20]]
    assert made.horizontal.tolist() == [[-5, 20, 80], [-10, 100, 130], [20, 100, 130]]
    [jammer] = made.jammers
    assert jammer.place.tolist() == [200, 50]
    assert jammer.route.tolist() == [[210, 50], [210, 60]]
    assert (jammer.emission, jammer.motion, jammer.speed, jammer.dwell) == ("sweeping", "patrol", 3.0, 4)
    assert made.start.tolist() == [[0, 10], [10, 0], [-10, 0]]


SINK = "sink: [300, 0]\n"
CASES = {
    "sink: [300": "no YAML, or cut short",
    "[1, 2]": "the file is",
    "walls: []": "the file has no sink",
    "sink: [300, 0, 0]": "sink=.*a place",
    "sink: 300": "sink=300: accepted is a place",
    "sink: [.nan, 0]": "sink=nan",
    "sink: [.inf, 0]": "sink=inf",
    "sink: [1.0e+300, 0]": "sink=1e\\+300",
    f"sink: [{10**400}, 0]": "a number of 401 letters",
    "sink: [true, 0]": "sink=true",
    "sink: ['300', 0]": "sink=300",
    SINK + "colour: red": "the file has colour; accepted are sink, source",
    SINK + "time_limit: 0": "scenario.time_limit=0",
    SINK + "time_limit: 1.5": "scenario.time_limit=1.5",
    SINK + "time_limit: .nan": "scenario.time_limit=nan",
    SINK + "wall_thickness: 2": "wall_thickness=2: accepted is 1 m, as world.wall_thickness says",
    SINK + "walls: 3": "walls=3: accepted is a list",
    SINK + "walls: [3]": r"walls\[0\] is 3",
    SINK + "walls: [{from: [0, 5], to: [9, 6]}]": r"walls\[0\]=.*along one of the axes",
    SINK + "walls: [{from: [0, 5]}]": r"walls\[0\] has no to",
    SINK + "walls: [{corner: [5, 5], opposite: [5, 9]}]": r"walls\[0\]=.*two corners",
    SINK + "walls: [{from: [5, 5], to: [5, .nan]}]": r"walls\[0\].to=nan",
    SINK + "jammers: [{emission: constant}]": r"jammers\[0\] has no place",
    SINK + "jammers: [{place: [1, 2], colour: red}]": r"jammers\[0\] has colour",
    SINK + "jammers: [{place: [1, 2], emission: loud}]": r"jammers\[0\].emission=loud: accepted is one of reactive",
    SINK + "jammers: [{place: [1, 2], motion: [fixed]}]": r"jammers\[0\].motion",
    SINK + "jammers: [{place: [1, 2], speed: fast}]": r"jammers\[0\].speed=fast",
    SINK + "jammers: [{place: [1, 2], duty: 2}]": r"jammers\[0\].duty=2",
    SINK + "jammers: [{place: [1, 2], dwell: 2.5}]": r"jammers\[0\].dwell=2.5",
    SINK + "jammers: [{place: [1, 2], route: [1, 2]}]": r"jammers\[0\].route\[0\]=1",
    SINK + "jammers: [" + "{place: [1, 2]}, " * 17 + "]": r"scenario.jammers=17",
    SINK + "starts: [[1, 2]]": r"scenario.start=float32 \[1, 2\]",
    SINK + "starts: [[1, 2], [1, 2], [3, 4]]": "scenario.start=.*a place of its own",
    SINK + "sink_estimate: [1]": "sink_estimate=",
    "a: &a [1]\nb: *a\n" + SINK: "an anchor or an alias",
    f"sink: {'[' * 30}{']' * 30}": "nested deeper",
    "!!python/object/apply:os.getcwd []": "no YAML, or cut short",
}


@pytest.mark.parametrize("text", CASES)
def test_what_is_wrong_is_named_with_file_and_field(text):
    with pytest.raises(InputError, match=CASES[text]) as caught:
        said(text)
    message = str(caught.value)
    assert message.startswith("world.file=my.yaml: ")
    assert "accepted" in message
    assert "\n" not in message
    assert len(message) < 400


def refused(text):
    """What a world is refused with; None if it is not."""
    try:
        assert np.isfinite(said(text).start).all()
    except InputError as error:
        return str(error)
    return None


YAML = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from(["sink", "source", "walls", "jammers", "starts", "time_limit", "wall_thickness",
                                        "sink_estimate", "other"]), YAML, max_size=5))  # fmt: skip
def test_any_content_is_a_world_or_one_line(content):
    refusal = refused(yaml.safe_dump({"sink": [300.0, 0.0], **content}))
    assert refusal is None or refusal.startswith("world.file=my.yaml: ")
    assert refusal is None or "\n" not in refusal


@given(st.text(max_size=60))
def test_any_text_is_a_world_or_one_line(text):
    assert "\n" not in (refused(text) or "")


def test_a_file_is_bounded_and_text(tmp_path):
    file = tmp_path / "w.yaml"
    for content in (b"#" * (LARGEST + 1), b"sink: \xff\xfe", b"", b"  \n"):
        file.write_bytes(content)
        with pytest.raises(InputError, match=r"world\.file=.*accepted is"):
            read_world(file)
    for path in (tmp_path, tmp_path / "none.yaml", "a\0b", 3):
        with pytest.raises(InputError, match=r"world\.file=.*accepted is"):
            read_world(path)


def test_settings_hold_the_text_and_the_file_may_go(tmp_path):
    file = tmp_path / "w.yaml"
    file.write_text("sink: [300, 0]")
    settings = Settings(world=World.from_file(file))
    file.unlink()
    assert make_scenario(settings, 0).sink.tolist() == [300, 0]
    with pytest.raises(InputError, match=r"world\.file="):  # a file named by a stranger's settings is never read
        World(file=str(file))


def test_the_command_line_names_a_file_as_a_world(tmp_path):
    assert by_path("world=some/my.yaml") == "world.file=some/my.yaml"
    assert by_path("world='a b.yml'") == "world.file='a b.yml'"
    for other in ("world=default", "grammar=my.yaml", "world.distance=5", "-m"):
        assert by_path(other) == other
    file = tmp_path / "w.yaml"
    file.write_text("sink: [300, 0]")
    config = {"seed": 1, "world": {"file": str(file), "content": None, "distance": 600.0}}
    assert with_world_text(config)["world"]["content"] == "sink: [300, 0]"
    assert config["world"]["content"] is None
    assert with_world_text({"world": {"file": None}}) == {"world": {"file": None}}
