"""Mappings to settings and back."""

import pytest

from slcs2_jax.config import InputError, Rules, Search, Settings, settings_from, settings_to_dict


def test_round_trip():
    settings = Settings(search=Search(generations=7, exchange=False), rules=Rules(grammar="both"), seed=3)
    assert settings_from(settings_to_dict(settings)) == settings


def test_top_level_names_and_their_places_in_sections_mean_the_same():
    assert settings_from({"grammar": "both"}) == settings_from({"rules": {"grammar": "both"}})
    assert settings_from({"generations": 3}).search.generations == 3


def test_a_group_of_no_settings_is_one():
    assert settings_from({"swarm": {}, "radio": {}}) == Settings()


@pytest.mark.parametrize(
    ("mapping", "part"),
    [
        ({"radio": {"noise": 1}}, "radio.noise: no such setting; did you mean radio.noise_dbm"),
        ({"speed": 1}, "swarm.speed"),
        ({"radio": 3}, "radio=3: accepted is a group of settings"),
        ({"zzz": {"qqq": 1}}, "zzz.qqq: no such setting; accepted are settings of world, radio"),
        ({"rules": {"grammar": "x"}, "grammar": "main"}, "grammar=main: accepted is one value"),
        ({"swarm": {"agents": {"n": 1}}}, "swarm.agents.n: no such setting"),
        ({"swarm": {"packets": {}}}, "swarm.packets={}: accepted is a whole number from 1 to 1000000"),
        ({"run_dir": {}}, "run_dir={}: accepted is a text or null"),
        ({"wings": {}}, "wings: no such setting"),
        ([1], "settings=[1]: accepted is a mapping of settings"),
    ],
)
def test_refused_in_one_line(mapping, part):
    with pytest.raises(InputError) as caught:
        settings_from(mapping)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)
