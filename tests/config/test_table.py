"""The tables of settings: every setting in each."""

import pytest

from slcs2_jax.config.registry import KINDS
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.config.table import reference_markdown, settings_help, settings_table


def test_every_setting_has_a_row_in_every_table():
    page = "\n" + reference_markdown()
    for _, field in settings_fields():
        assert page.count(f"\n| `{field.name}` |") == 1
        assert f"\n  {field.name}=" in settings_help()


def test_a_row_of_the_page_says_all_there_is():
    line = next(line for line in reference_markdown().splitlines() if line.startswith("| `learning.beta_q` |"))
    assert line == (
        "| `learning.beta_q` | `0.71` | – | a finite number >= 0 and < 1 | assumed | discount of the next step's best "
        "quality | after XCS |"
    )


@pytest.fixture
def part():
    KINDS["search"].add("mine", object(), "a_plug_in")
    yield "mine"
    KINDS["search"].forget("mine")


def test_parts_that_are_registered_are_among_the_accepted(part):
    [row] = [row for row in settings_table() if row.name == "search.name"]
    assert row.names == ("slcs2", "random", "informed", "starters", "mine")
    assert row.accepted == "one of slcs2, random, informed, starters, mine, or a name that plugins= brings"
    assert "(slcs2, random, informed, starters, mine)" in settings_help()
