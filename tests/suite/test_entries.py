"""Entries: the suite's own can all be deployed, and a user's are taken or refused in one line."""

from __future__ import annotations

import pytest

from slcs2_jax.config import InputError, Settings, settings_from
from slcs2_jax.learning import algorithms
from slcs2_jax.learning.algorithms import settings_of
from slcs2_jax.search.slcs2 import check_parts
from slcs2_jax.suite.entries import (
    ALGORITHMS,
    EVOLVED,
    HAND_MADE,
    LEARNED,
    ORDER,
    YOURS,
    chosen,
    entry_named,
    shipped,
)
from slcs2_jax.suite.networks import changes


def test_every_field_takes_part():
    fields = {name: entry.field for name, entry in shipped().items()}
    assert tuple(fields) == ORDER
    assert list(fields.values()).count(HAND_MADE) == list(fields.values()).count(EVOLVED) == 6
    assert [name for name, field in fields.items() if field == LEARNED] == ["ippo", "ippo_recurrent", "strategy"]
    assert all(entry.title and entry.about for entry in shipped().values())


@pytest.mark.parametrize("name", [name for name, entry in shipped().items() if not entry.trained])
def test_hand_made_entries_are_rules_that_can_be_said(name):
    entry = shipped()[name]
    rules = entry.decision_list()
    assert len(rules.rules) >= 3
    assert entry.content.startswith("# ")


@pytest.mark.parametrize("name", [name for name, entry in shipped().items() if entry.field == EVOLVED])
def test_searches_are_settings_that_exist(name, tiny):
    settings = tiny.worlds["few"].settings(tiny.worlds["few"].seeds_of("train")[0], shipped()[name].settings)
    check_parts(settings.search)
    assert settings.swarm == settings_from(dict(tiny.worlds["few"].stated)).swarm


@pytest.mark.parametrize("name", [name for name, entry in shipped().items() if entry.field == LEARNED])
def test_trainings_of_networks_are_settings_that_exist(name):
    entry = shipped()[name]
    made = settings_of(entry.algorithm, changes(entry, 3_000_000, 8))
    assert made.snapshot == 375_000
    assert entry.algorithm == "strategy" or made.anneal == 3_000_000


def test_algorithms_are_those_of_the_learning_room():
    assert tuple(algorithms.ALGORITHMS) == ALGORITHMS


def test_a_users_network_is_an_entry(tmp_path):
    file = tmp_path / "wide.yaml"
    file.write_text("algorithm: ippo\nbudget: 0.5\nsettings: {ippo: {anneal: null}, network: {hidden: [128]}}\n")
    entry = entry_named(str(file))
    assert (entry.field, entry.algorithm, entry.budget, entry.trained) == (YOURS, "ippo", 0.5, True)
    assert settings_of("ippo", changes(entry, 800, 8)).anneal is None
    before = entry.digest
    file.write_text(file.read_text().replace("0.5", "0.25"))
    assert entry_named(str(file)).digest != before


def test_a_setting_of_a_network_that_is_none_is_one_line(tmp_path):
    file = tmp_path / "odd.yaml"
    file.write_text("algorithm: ippo\nsettings: {ippo: {clip: 7}}\n")
    with pytest.raises(InputError, match=r"^entry=odd: ippo\.clip=7: accepted is [^\n]*$"):
        changes(entry_named(str(file)), 800, 8)


def test_slcs2_is_the_papers():
    assert shipped()["slcs2"].settings == {}


def test_a_users_list_is_an_entry(tmp_path):
    file = tmp_path / "mine.txt"
    file.write_text("# Mine: goes straight\npacket held => move toward sink\n")
    entry = entry_named(str(file))
    assert (entry.name, entry.title, entry.about, entry.field) == ("mine", "Mine", "goes straight", YOURS)
    assert [one.name for one in chosen(f"designed,{file}")] == ["designed", "mine"]
    before = entry.digest
    file.write_text("packet held => move toward source\n")
    assert entry_named(str(file)).digest != before


def test_a_users_search_is_an_entry(tmp_path):
    file = tmp_path / "greedy.yaml"
    file.write_text("title: Greedy\nsettings: {acceptance: best, learning: {alpha_grasp: 0.0}}\n")
    entry = entry_named(str(file))
    assert entry.trained
    assert entry.settings == {"acceptance": "best", "learning.alpha_grasp": 0.0}


def test_a_users_search_may_evolve_in_many_worlds(tmp_path):
    file = tmp_path / "many.yaml"
    file.write_text("settings: {acceptance: best}\n")
    one = entry_named(str(file))
    file.write_text("train_worlds: 8\nsettings: {acceptance: best}\n")
    many = entry_named(str(file))
    assert (one.train_worlds, many.train_worlds) == (1, 8)
    assert one.digest != many.digest


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("designed.txt", "packet held => move toward sink", "entry=designed: accepted is another name"),
        ("a b.txt", "packet held => move toward sink", "a name of letters"),
        ("mine.yaml", "settings: {swarm: {agents: 3}}", "settings of search"),
        ("mine.yaml", "settings: {search: {episodes: 3}}", "the suite gives it"),
        ("mine.yaml", "settings: {search: {nothing: 3}}", "no such setting"),
        ("mine.yaml", "algorithm: dqn\nsettings: {}", "algorithm=dqn: accepted is one of ippo, strategy"),
        ("mine.yaml", "algorithm: [ippo]\nsettings: {}", "algorithm=.*: accepted is one of ippo, strategy"),
        ("mine.yaml", "algorithm: ippo\nbudget: 10\nsettings: {}", "budget=10: accepted is a share"),
        ("mine.yaml", "algorithm: ippo\nbudget: .nan\nsettings: {}", "budget=nan: accepted is a share"),
        ("mine.yaml", "algorithm: ippo\nsettings: {ippo: {snapshot: 3}}", "no ippo.snapshot: the suite gives it"),
        ("mine.yaml", "budget: 1\nsettings: {}", "that of a network has algorithm"),
        ("mine.yaml", "train_worlds: 65\nsettings: {}", "train_worlds=65: accepted is a whole number from 1 to 64"),
        ("mine.yaml", "train_worlds: true\nsettings: {}", "train_worlds=true: accepted is a whole number"),
        ("mine.yaml", "algorithm: ippo\ntrain_worlds: 2\nsettings: {}", "has title, about, settings"),
        ("mine.yaml", "settings: 3", "has title, about, settings"),
        ("mine.yaml", "settings: {}\ncode: x", "has title, about, settings"),
        ("mine.yaml", "[", "no YAML"),
        ("mine.txt", "packet held => fly", r"entry=.*mine\.txt: policy 'mine': line 1: action: 'fly'"),
        ("mine.txt", "# nothing", r"entry=.*mine\.txt: .*0 rules"),
        ("mine.py", "", "entry=.*: accepted is one of direct_delivery"),
    ],
)
def test_what_is_no_entry_is_one_line(tmp_path, name, text, said):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=said) as caught:
        entry_named(str(tmp_path / name))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_one_line():
    with pytest.raises(InputError, match=r"entry=nowhere\.txt: No such file"):
        entry_named("nowhere.txt")
    with pytest.raises(InputError, match=r"entry=\\x00\.txt: accepted is the path"):
        entry_named("\0.txt")


def test_an_entry_changes_nothing_of_the_worlds():
    usual = Settings()
    for entry in shipped().values():
        if entry.field == LEARNED:
            assert {path.partition(".")[0] for path in entry.settings} <= {entry.algorithm, "network"}
            continue
        made = settings_from(dict(entry.settings or {}))
        for section in ("world", "radio", "jammers", "swarm", "task"):
            assert getattr(made, section) == getattr(usual, section)
