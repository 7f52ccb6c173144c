"""Plug-ins: modules that the user names in the very command; no file imports one, and changed ones are refused."""

import hashlib
import sys

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config import plugins as loading
from slcs2_jax.config.registry import KINDS

SOURCE = """
from slcs2_jax.config.registry import register

@register("fading", "rain of a test")
def rain():
    return 1
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder; what is imported and registered from it is forgotten again."""
    monkeypatch.chdir(tmp_path)
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]
    KINDS["fading"].forget("rain of a test")


def refused(*modules):
    with pytest.raises(InputError) as found:
        loading.load(modules)
    assert "\n" not in str(found.value)
    return str(found.value)


def test_a_module_of_the_current_folder_registers_its_parts(folder):
    (folder / "plugged_rain.py").write_text(SOURCE)
    path = list(sys.path)
    found = loading.load(["plugged_rain"])
    assert found == {"plugged_rain": hashlib.sha256(SOURCE.encode()).hexdigest()}
    assert KINDS["fading"].home("rain of a test") == "plugged_rain"
    assert KINDS["fading"].get("rain of a test")() == 1
    assert sys.path == path
    assert loading.load(["plugged_rain"]) == found
    assert loading.load([]) == {}


def test_a_module_in_a_package(folder):
    (folder / "plugged_pack").mkdir()
    (folder / "plugged_pack" / "__init__.py").write_text("")
    (folder / "plugged_pack" / "inner.py").write_text(SOURCE)
    assert list(loading.load(["plugged_pack.inner"])) == ["plugged_pack.inner"]
    assert KINDS["fading"].home("rain of a test") == "plugged_pack.inner"


@pytest.mark.parametrize("name", ["plugged-rain", "plugged_rain.py/", "../x", "a b", "", "a..b", 3, None])
def test_what_is_no_name_of_a_module_is_refused(folder, name):
    assert refused(name).startswith("plugins=")
    assert "accepted is names of Python modules, plugins=[my_module]" in refused(name)


def test_a_module_that_is_not_there(folder):
    message = "plugins=plugged_nowhere: accepted is the name of a module in the current folder or on Python's path"
    assert refused("plugged_nowhere") == message


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("import plugged_absent", "its import failed (ModuleNotFoundError: "),
        ("1 / 0", "its import failed (ZeroDivisionError: division by zero)"),
        ("def", "its import failed (SyntaxError: "),
        ("raise ValueError('two\\nlines')", "its import failed (ValueError: "),
        (SOURCE.replace("fading", "weather"), "register=weather: accepted is one of clause, "),
        (SOURCE.replace("rain of a test", "none"), "register: fading none is this package's"),
    ],
)
def test_a_module_that_fails_is_named_with_the_reason(folder, source, told):
    (folder / "plugged_bad.py").write_text(source)
    path = list(sys.path)
    assert refused("plugged_bad").startswith("plugins=plugged_bad: " + told)
    assert sys.path == path


def test_a_run_goes_on_only_with_the_plug_ins_it_was_begun_with():
    recorded = {"one": "1" * 64, "two": "2" * 64}
    loading.check_same(recorded, recorded, "runs/a")
    loading.check_same(recorded, recorded | {"more": "3" * 64}, "runs/a")
    loading.check_same({}, {}, "runs/a")
    with pytest.raises(
        InputError, match=r"^runs/a: was made with the plug-in two, .*plugins=\[one,two\], if you trust"
    ):
        loading.check_same(recorded, {"one": "1" * 64}, "runs/a")
    with pytest.raises(
        InputError, match=r"^runs/a: the plug-in two has changed since; .*\(SHA-256 222222222222\.\.\.\)"
    ):
        loading.check_same(recorded, recorded | {"two": "3" * 64}, "runs/a")
