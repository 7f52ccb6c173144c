"""Plug-ins: modules that the user names in the very command; no file imports one, and changed ones are refused."""

import hashlib
import sys

import pytest

from slcs2_jax.config import InputError, Settings, settings_from, settings_to_dict
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
    for name in loading.loaded():
        loading.forget(name)


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


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        ([], ()),
        (["seed=1", "plugins=[a,b.c]"], ("a", "b.c")),
        (["plugins=mine"], ("mine",)),
        (["plugins=[ 'mine' , \"theirs\" ]"], ("mine", "theirs")),
        (["plugins=[]"], ()),
        (["plugins=[a]", "plugins=[b]"], ("b",)),
    ],
)
def test_the_names_on_a_command_line(arguments, names):
    assert loading.named_in(arguments) == names


def test_settings_that_name_a_plug_in_need_it_loaded_and_import_nothing(folder):
    (folder / "plugged_rain.py").write_text(SOURCE)
    for make in (lambda: Settings(plugins=("plugged_rain",)), lambda: settings_from({"plugins": ["plugged_rain"]})):
        with pytest.raises(loading.PluginError, match=r"accepted is plugins=\[plugged_rain\], if you trust it"):
            make()
    assert "plugged_rain" not in sys.modules
    loading.load(["plugged_rain"])
    settings = settings_from({"plugins": ["plugged_rain"]})
    assert settings == Settings(plugins=("plugged_rain",))
    assert settings_from(settings_to_dict(settings)) == settings


def test_a_file_is_read_only_with_the_plug_ins_it_was_made_with(folder):
    for name in ("plugged_one", "plugged_two"):
        (folder / f"{name}.py").write_text("")
    assert loading.recorded(()) == {}
    loading.load(["plugged_one", "plugged_two"])
    record = loading.recorded(("plugged_one", "plugged_two"))
    loading.check_same(record, "runs/a")
    loading.check_same({}, "runs/a")
    loading.forget("plugged_two")
    with pytest.raises(
        loading.PluginError, match=r"^runs/a: needs the plug-in plugged_two, .*plugins=\[plugged_one,plugg"
    ):
        loading.check_same(record, "runs/a")
    (folder / "plugged_two.py").write_text("# another")
    loading.load(["plugged_two"])
    with pytest.raises(loading.PluginError, match=r"^runs/a: the plug-in plugged_two has changed since; .*\.\.\.\)"):
        loading.check_same(record, "runs/a")
