"""Plug-ins: imported because the user names them, never because a file does; recorded, and held to what they were."""

import hashlib
import itertools
import sys

import pytest

from slcs2_jax.config import InputError, Settings, plugins, settings_from, settings_to_dict

_NUMBER = itertools.count()


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Writes a module of a name of its own into the current folder; gives its name and file."""
    monkeypatch.chdir(tmp_path)

    def write(text: str) -> tuple:
        name = f"slcs2_test_plugin_{next(_NUMBER)}"
        file = tmp_path / f"{name}.py"
        file.write_text(text)
        return name, file

    yield write
    for name in list(plugins.loaded()):
        plugins.forget(name)


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
    assert plugins.named_in(arguments) == names


def test_a_module_in_the_current_folder_is_imported_and_its_source_is_known_by_its_digest(module):
    name, file = module("LOADED = True\n")
    assert plugins.load([name]) == {name: hashlib.sha256(file.read_bytes()).hexdigest()}
    assert sys.modules[name].LOADED
    assert plugins.recorded((name,)) == {"plugins": {name: plugins.loaded()[name]}}
    assert plugins.recorded(()) == {}
    plugins.check_same(plugins.recorded((name,)), "run")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("raise RuntimeError('no\\nluck')", r"its import failed \(RuntimeError: no luck\)"),
        ("import slcs2_no_such_module", "its import failed"),
        ("x = (", "its import failed"),
        (
            "import slcs2_jax\nslcs2_jax.config.registry.register('wheel', 'round')",
            "register=wheel: accepted is one of",
        ),
    ],
)
def test_what_cannot_be_imported_is_one_line(module, text, says):
    name, _ = module(text)
    with pytest.raises(InputError, match=says) as caught:
        plugins.load([name])
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f"plugins={name}: ")


@pytest.mark.parametrize("name", ["no_such_module_anywhere", "../mine", "", "a b", "os;"])
def test_what_is_no_module_is_one_line(name):
    with pytest.raises(InputError, match=r"^plugins="):
        plugins.load([name])


def test_settings_that_name_a_plug_in_need_it_loaded_and_import_nothing(module):
    name, _ = module("LOADED = True\n")
    for make in (lambda: Settings(plugins=(name,)), lambda: settings_from({"plugins": [name]})):
        with pytest.raises(plugins.PluginError, match=rf"accepted is plugins=\[.*{name}\], if you trust it"):
            make()
    assert name not in sys.modules
    plugins.load([name])
    settings = settings_from({"plugins": [name]})
    assert settings == Settings(plugins=(name,))
    assert settings_from(settings_to_dict(settings)) == settings


def test_a_changed_source_is_told(module):
    name, _ = module("LOADED = True\n")
    plugins.load([name])
    with pytest.raises(plugins.PluginError, match=f"run: the plug-in {name} has changed since"):
        plugins.check_same({"plugins": {name: "0" * 64}}, "run")
