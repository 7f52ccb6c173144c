"""Files are regular ones, in their folder, of a size that fits."""

import os
import socket

import pytest

from slcs2_jax.config import InputError, StorageError, door
from slcs2_jax.config.door import (
    check_below,
    folders_below,
    name_inside,
    opened_folder,
    present,
    read_file,
    reading,
    telling_damage,
)


@pytest.fixture
def outside(tmp_path):
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "x").write_bytes(b"secret")
    return tmp_path / "outside"


@pytest.fixture
def run(tmp_path):
    (tmp_path / "run").mkdir()
    return tmp_path / "run"


def test_a_regular_file_is_read_whole(run):
    (run / "x").write_bytes(b"abc")
    assert read_file(run / "x", 3) == b"abc"
    with pytest.raises(InputError, match="3 bytes; accepted are at most 2"):
        read_file(run / "x", 2)
    with pytest.raises(FileNotFoundError):
        read_file(run / "y", 2)


def make_socket(path):
    with socket.socket(socket.AF_UNIX) as one:
        os.chdir(path.parent)
        one.bind(path.name)


KINDS = {
    "a link": lambda path, outside: path.symlink_to(outside / "x"),
    "a folder": lambda path, outside: path.mkdir(),
    "a pipe": lambda path, outside: os.mkfifo(path),
    "a socket": lambda path, outside: make_socket(path),
}


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_else_it_is_is_refused_by_what_it_is(kind, run, outside, monkeypatch):
    monkeypatch.chdir(run)
    KINDS[kind](run / "x", outside)
    with pytest.raises(InputError, match=f"is {kind}; accepted is a regular file"):
        read_file(run / "x", 100)


def test_a_device_is_refused():
    with pytest.raises(InputError, match="is a device; accepted is a regular file"):
        read_file(door.Path("/dev/null"), 100)


def test_a_link_put_in_the_place_of_a_file_just_looked_at_is_not_followed(run, outside, monkeypatch):
    (run / "x").write_bytes(b"abc")
    looked = os.stat

    def swap(name, **keywords):
        found = looked(name, **keywords)
        if name == "x":
            (run / "x").unlink()
            (run / "x").symlink_to(outside / "x")
        return found

    monkeypatch.setattr(door.os, "stat", swap)
    with pytest.raises(OSError, match="symbolic links"):
        read_file(run / "x", 100)


def test_the_folder_may_be_a_link_and_none_inside_it(run, outside, tmp_path):
    (tmp_path / "named").symlink_to(outside)
    assert read_file(tmp_path / "named" / "x", 100) == b"secret"
    (run / "below").symlink_to(outside)
    with pytest.raises(InputError, match="its folder below is a link; accepted is a folder"):
        read_file(run / "below" / "x", 100, inside=run)


def test_a_system_without_descriptors_of_folders_refuses_the_same(run, outside, monkeypatch):
    monkeypatch.setattr(door, "_RELATIVE", False)
    (run / "below").symlink_to(outside)
    with pytest.raises(InputError, match="its folder below is a link"), reading(run / "below" / "x", 100, inside=run):
        pass
    with opened_folder(outside) as folder:
        assert (folder.fd, folder.names()) == (None, ["x"])
    assert read_file(outside / "x", 100, inside=outside.parent) == b"secret"


def test_a_name_is_present_if_it_leads_nowhere(run, monkeypatch):
    assert not present(run / "x")
    assert not present(run / "x\0")
    (run / "x").symlink_to(run / "nowhere")
    assert present(run / "x")
    monkeypatch.setattr(door.os, "lstat", lambda path: (_ for _ in ()).throw(PermissionError(13, "Permission denied")))
    with pytest.raises(StorageError, match=r"x: cannot be looked at \(Permission denied\)"):
        present(run / "x")


LEAVING = ("", "..", "../x", "a/../../x", "/x", "\\x", "C:\\x", "a\\..\\x", "a\nb", "\x1b", 3, None)


@pytest.mark.parametrize("name", LEAVING)
def test_names_that_leave_their_folder(name):
    with pytest.raises(InputError, match="accepted is the name of a folder below this one"):
        name_inside(name)


def test_names_inside():
    assert str(name_inside("a/b c")) == "a/b c"
    assert str(name_inside("a\\b")) == "a/b"


def test_no_link_on_the_way(run, outside):
    (run / "below").symlink_to(outside)
    (run / "file").touch()
    check_below(run, run / "new" / "newer")
    for name, says in (("below", "is a link"), ("file", "is a file")):
        with pytest.raises(InputError, match=f"{name}: {says}; accepted is a folder"):
            check_below(run, run / name / "x")


def test_folders_below_are_found_in_order_and_links_passed_over(run, outside):
    for name in ("b/c", "a"):
        (run / name).mkdir(parents=True)
    (run / "a" / "link").symlink_to(outside)
    passed = []
    assert [str(path.relative_to(run)) for path in folders_below(run, passed)] == [".", "a", "b", "b/c"]
    assert passed == [f"{run / 'a' / 'link'}: is a link to a folder"]


def test_endless_folders_are_refused(run, monkeypatch):
    deep = run
    for _ in range(door.DEEPEST + 1):
        deep = deep / "d"
    deep.mkdir(parents=True)
    with pytest.raises(InputError, match="nested at most 32 deep"):
        list(folders_below(run))
    monkeypatch.setattr(door, "MOST_FOLDERS", 3)
    with pytest.raises(InputError, match="at most 3 folders below it"):
        list(folders_below(run))


def test_damage_of_any_kind_is_one_line():
    for error in (KeyError("a\nb"), RecursionError(), MemoryError()):
        with pytest.raises(InputError, match=r"^damaged or cut short: [^\n]+$"), telling_damage():
            raise error
    with pytest.raises(KeyboardInterrupt), telling_damage():
        raise KeyboardInterrupt
