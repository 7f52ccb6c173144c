"""Random texts where a person says something: each is refused in one line, or means what it says.

SLCS2_INPUTS sets how many inputs each test tries.
"""

from __future__ import annotations

import dataclasses

import pytest
import yaml
from hypothesis import assume, example, given
from hypothesis import strategies as st

from slcs2_jax.commands import find, suite, transfer
from slcs2_jax.commands.looked_at import told_apart
from slcs2_jax.config import Compute, InputError, Settings, World, plugins
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.config.worlds import MOST_WORLDS, kinds_of
from slcs2_jax.grammar import load_grammar
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.policy.decision_list import parse_decision_list
from slcs2_jax.suite.entries import _list, _training, chosen
from slcs2_jax.suite.training import plan
from slcs2_jax.suite.worlds import load_suite, seeds_of
from slcs2_jax.world.layout import Jammer
from slcs2_jax.world.scenario import make_scenario
from slcs2_jax.world.scenario_check import check_scenario
from slcs2_jax.world.world_file import _FIELDS, scenario_text
from tests.faults.spoiling import documents, many, one_line

WORDS = sorted({*load_grammar("both").text.split(), "=>", "&", "reflex:", "#", "\n"})


@many
@given(entries=st.lists(
    st.one_of(
        st.builds(
            "".join,
            st.lists(st.sampled_from(["open", "urban", "short", "long", "/", "..", "0", "7", "2147483647", "9" * 10])),
        ),
        st.text(max_size=8),
    ),
    max_size=3,
))  # fmt: skip
@example(entries=["open/0..999", "open/1000"])
def test_any_list_of_worlds(entries):
    try:
        found = kinds_of(entries)
    except InputError as error:
        one_line(error)
        return
    worlds = [(one.name, seed) for one in found for seed in one.seeds]
    assert len(worlds) == len(set(worlds)) <= MOST_WORLDS
    assert len(found) == len(entries)


@many
@given(text=st.one_of(st.lists(st.sampled_from(WORDS), max_size=40).map(" ".join), st.text(max_size=60)))
def test_any_text_as_a_decision_list(text):
    try:
        found = parse_decision_list(text)
    except InputError as error:
        one_line(error)
        return
    again = parse_decision_list("\n".join(rule.text() for rule in found.rules))
    assert again.rules == found.rules
    assert {rule.action for rule in found.rules} <= set(range(len(Vocabulary.current().actions)))


PLACES = st.lists(st.floats(-500, 500) | st.integers(-500, 500), min_size=2, max_size=2)
WALLS = st.fixed_dictionaries({"corner": PLACES, "opposite": PLACES}) | st.builds(
    lambda at, low, high: {"from": [at, low], "to": [at, high]}, st.integers(1, 90), st.floats(-9, 9), st.floats(-9, 9)
)
JAMMER = st.sampled_from([field.name for field in dataclasses.fields(Jammer)])
SMALL = Settings(world=World(distance=120.0, time_limit=60))
GOOD = yaml.safe_load(scenario_text(make_scenario(SMALL, 1)))
ANY = documents(
    [*_FIELDS, *(field.name for field in dataclasses.fields(Jammer))], ["reactive", "patrol", "nan", ".inf"]
)


@many
@given(
    content=st.one_of(
        ANY,
        st.fixed_dictionaries({}, optional=dict.fromkeys(_FIELDS, ANY)).map(lambda some: GOOD | some),
        st.fixed_dictionaries(
            {"sink": PLACES},
            optional={
                "walls": st.lists(WALLS, max_size=4),
                "jammers": st.lists(st.dictionaries(JAMMER, PLACES | st.lists(PLACES, max_size=2) | ANY), max_size=2),
                "time_limit": st.integers(-1, 10**10) | st.floats(),
                "starts": st.lists(PLACES, max_size=8),
            },
        ),
    )
)  # fmt: skip
@example(content={"sink": [100, 0], "jammers": [{"place": [50, 0], "emission": ["reactive"]}]})
@example(content={"sink": [100, 0], "jammers": [{"place": [50, 0], "emission": {}}]})
@example(content={"sink": [100, 0], "time_limit": {}})
def test_any_world_file(content):
    text = yaml.safe_dump(content)
    settings = dataclasses.replace(SMALL, world=dataclasses.replace(SMALL.world, file="some.yaml", content=text))
    try:
        found = make_scenario(settings, 1)
    except InputError as error:
        one_line(error)
        return
    check_scenario(found, settings)
    assert make_scenario(settings, 1).start.tobytes() == found.start.tobytes()


@pytest.fixture(scope="module")
def world():
    return load_suite().worlds["few"]


SETTINGS_NAMES = [field.name for _, field in settings_fields()]
ENTRY_NAMES = ["title", "about", "settings", "algorithm", "budget", "search", "strategy", "ippo", "network", "name"]
ENTRIES = st.fixed_dictionaries(
    {},
    optional={
        "title": documents(["a"], ["x"]),
        "about": documents(["a"], ["x"]),
        "algorithm": st.sampled_from(["ippo", "strategy", "none"]) | documents(["a"], ["ippo"]),
        "budget": st.floats() | st.integers(-1, 2) | documents(["a"], ["1"]),
        "settings": st.dictionaries(
            st.sampled_from([
                *SETTINGS_NAMES, "search", "search.batch", "search.name", "search.final_every", "strategy.population",
                "ippo.episodes", "network.hidden", "search.episodes", 3,
            ]),
            documents(ENTRY_NAMES, ["informed", "random", "starters", "null"]),
            max_size=4,
        ),
    },
)  # fmt: skip


@many
@given(content=ENTRIES | documents(ENTRY_NAMES, ["informed", "ippo"]))
@example(content={"settings": {"search.batch": "x"}})
@example(content={"settings": {"search.batch": 0}})
@example(content={"settings": {"search.name": "informed", "search.final_every": None}})
@example(content={"settings": {"rules.rules": [1]}})
@example(content={"settings": {"rules": {"rules": 3}, 3: 4}})
@example(content={"algorithm": "ippo", "settings": {3: 4, "ippo.episodes": 2}})
@example(content={"algorithm": ["ippo"], "settings": {}})
def test_any_entry_of_the_suite(content, world, tmp_path_factory):
    try:
        entry = _training("mine", yaml.safe_dump(content))
        [training] = plan(entry, [world], tmp_path_factory.getbasetemp(), compute=Compute(), trainings=1, episodes=3)
    except InputError as error:
        one_line(error)
        return
    assert entry.trained
    assert training.budget > 0


@many
@given(text=st.text(max_size=200))
def test_any_text_as_a_list_that_takes_part(text):
    found = _list("mine", text, "yours")
    assert len(found.title) <= 80
    try:
        found.decision_list()
    except InputError as error:
        one_line(error)


@many
@given(
    said=st.text(max_size=20)
    | st.lists(st.sampled_from(["slcs2", "designed", ",", "[", "]", " ", "x.txt", "/", "..", "\0", ".npz"])).map(
        "".join
    )
)
def test_any_choice_of_entries_and_worlds(said):  # fmt: skip
    for choose in (chosen, load_suite().chosen):
        try:
            assert choose(said)
        except InputError as error:
            one_line(error)


@many
@given(
    said=st.text(max_size=12) | st.integers().map(str) | st.floats().map(str), split=st.sampled_from(["test", "train"])
)
def test_any_count_of_the_suite(said, split, world):
    try:
        count = suite._count("seeds", said)
        assert 0 < count <= 10**6
        assert len(seeds_of(world, split, count)) == count
    except InputError as error:
        one_line(error)


@many
@given(given=documents(["a"], ["open/short/0..7", "open/3", "lunar/1"]))
@example(given=["open/short/0", "open/short/0"])
def test_any_worlds_of_a_transfer(given):
    try:
        kinds = transfer._kinds(given, [])
    except InputError as error:
        one_line(error)
        return
    assert sum(len(kind.seeds) for kind in kinds) > 0 or given is None


@many
@given(
    name=st.sampled_from(["suite", "transfer", "found", "replay", "report", "rules", "watch", "world"]), data=st.data()
)
def test_any_options_of_a_command(name, data):
    """Told apart, each in the type of its default."""
    command = find(name)
    defaults = getattr(command, "_DEFAULTS", dict.fromkeys(command.OPTIONS))
    names = st.sampled_from([*command.OPTIONS, "seed", "x", ""])
    values = st.text(max_size=8) | st.integers().map(str) | st.sampled_from(["on", "off", "null", "[]", "\0", "9" * 12])
    arguments = data.draw(st.lists(st.builds("{}={}".format, names, values) | st.text(max_size=6), max_size=4))
    try:
        _, options, _ = told_apart(arguments, defaults)
    except InputError as error:
        one_line(error)
        return
    for option, default in defaults.items():
        assert options[option] is None or default is None or type(options[option]) is type(default)


@many
@given(
    text=st.text(max_size=20)
    | st.lists(st.sampled_from(["[", "]", ",", "'", '"', " ", ".", "no_such_module"])).map("".join)
)
def test_any_names_of_plug_ins(text):  # fmt: skip
    named = plugins.named_in([f"plugins={text}"])
    assume(not any(name.split(".")[0].isidentifier() and "no_such" not in name for name in named))  # none is imported
    try:
        assert plugins.load(named) == {}
    except InputError as error:
        one_line(error)
