"""A search chosen in Python brings the parts that it brings on the command line."""

from __future__ import annotations

import dataclasses

import pytest
import yaml

import slcs2_jax as slcs2
from slcs2_jax import cli
from slcs2_jax.config.conf import groups
from slcs2_jax.config.schema import settings_from
from tests.builders import registered


@pytest.mark.parametrize("name", groups()["search"])
def test_as_on_the_command_line(name, capfd):
    assert cli.main(["evolve", "--cfg", "job", f"search={name}"]) == 0
    assert slcs2.with_search(slcs2.Settings(), name) == settings_from(yaml.safe_load(capfd.readouterr().out))


def test_what_the_choice_does_not_say_stays():
    settings = slcs2.Settings(search=slcs2.Search(episodes=50), knowledge=slcs2.Knowledge(rules="my.txt"))
    chosen = slcs2.with_search(settings, "informed")
    assert (chosen.search.episodes, chosen.knowledge.rules, chosen.knowledge.mode) == (50, "my.txt", "reflex")
    with registered({"search": {"of_a_plug_in": print}}):
        alone = slcs2.with_search(settings, "of_a_plug_in")
        assert alone == dataclasses.replace(settings, search=dataclasses.replace(settings.search, name="of_a_plug_in"))
