"""Parts by name: this package's first, users' after them, and no name for two."""

import subprocess
import sys

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config.registry import KINDS, LONGEST_NAME, Registry, register


@pytest.fixture
def registry():
    return Registry("fading", "radio.fading", "for tests", {"none": "math:pi", "some": "math:tau"})


def test_this_packages_come_first_and_users_in_their_order(registry):
    assert registry.names() == ("none", "some")
    registry.add("b", 2, "mine")
    registry.add("a", 1, "mine")
    assert registry.names() == ("none", "some", "b", "a")
    assert registry.own() == ("b", "a")
    assert (registry.home("a"), registry.home("none")) == ("mine", None)
    assert (registry.get("a"), registry.get("b")) == (1, 2)


def test_this_packages_are_imported_when_asked_for(registry):
    import math

    assert registry.get("some") == math.tau
    assert registry.names() == ("none", "some")
    assert registry.own() == ()


def test_an_unknown_name_is_refused_with_those_that_exist(registry):
    registry.add("mine", 1, "here")
    with pytest.raises(InputError) as found:
        registry.get("rain")
    assert str(found.value) == (
        "radio.fading=rain: accepted is one of none, some, mine, or a name that plugins= brings"
    )


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * (LONGEST_NAME + 1), 3, None, "\x1b[2J"])
def test_a_name_is_a_short_printable_text(registry, name):
    with pytest.raises(InputError, match=r"^register: fading .*accepted is a name of 1 to 80 characters$") as found:
        registry.add(name, 1, "here")
    assert "\n" not in str(found.value)
    assert registry.own() == ()
    registry.add("x" * LONGEST_NAME, 1, "here")


def test_no_name_is_taken_twice_but_by_the_same_module(registry):
    with pytest.raises(InputError, match="fading none is this package's; accepted is another name"):
        registry.add("none", 1, "here")
    registry.add("mine", 1, "here")
    registry.add("mine", 2, "here")  # reloaded
    assert registry.get("mine") == 2
    assert registry.own() == ("mine",)
    with pytest.raises(InputError, match="fading mine is that of the plug-in here already"):
        registry.add("mine", 3, "elsewhere")
    assert registry.get("mine") == 2


def test_what_is_forgotten_is_gone_and_this_packages_stay(registry):
    registry.add("mine", 1, "here")
    registry.forget("mine")
    registry.forget("mine")
    registry.get("none")
    registry.forget("none")
    assert registry.names() == ("none", "some")
    registry.add("mine", 1, "elsewhere")


def test_the_decorator_returns_what_it_registers_and_knows_its_module():
    try:

        @register("clause", "a clause of this test")
        def part(view):
            return view

        assert KINDS["clause"].get("a clause of this test") is part
        assert KINDS["clause"].home("a clause of this test") == __name__
    finally:
        KINDS["clause"].forget("a clause of this test")
    with pytest.raises(InputError, match=r"^register=weather: accepted is one of clause, action, move target, "):
        register("weather", "rain")


def test_every_kind_is_filed_under_its_name_and_says_what_it_is():
    for kind, registry in KINDS.items():
        assert registry.kind == kind
        assert registry.setting
        assert registry.meaning
        assert registry.own() == ()


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind in KINDS for name in KINDS[kind].names()])
def test_every_part_of_this_package_is_where_it_is_said_to_be(kind, name):
    assert callable(KINDS[kind].get(name))


def test_listing_names_does_not_start_jax():
    code = "import sys; from slcs2_jax.config.registry import KINDS; [r.names() for r in KINDS.values()]"
    subprocess.run([sys.executable, "-c", code + "; assert 'jax' not in sys.modules"], check=True)
