"""Files are whole or as they were."""

import os

import pytest

from slcs2_jax.config import InputError, StorageError
from slcs2_jax.results.files import (
    append,
    delete,
    delete_others,
    make_folder,
    names_in,
    remove_leftovers,
    sync,
    write_text,
    write_whole,
)


def test_a_file_that_cannot_be_finished_leaves_the_old_one(tmp_path):
    write_text(tmp_path / "x", "old")

    def fail(file) -> None:
        file.write(b"new")
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_whole(tmp_path / "x", fail)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("x", "old")]


def test_files_have_the_usual_permissions(tmp_path):
    mask = os.umask(0o027)
    try:
        write_text(tmp_path / "x", "text")
    finally:
        os.umask(mask)
    assert (tmp_path / "x").stat().st_mode & 0o777 == 0o640


def test_a_refusal_names_the_file_and_is_one_line(tmp_path):
    for act in (lambda path: write_text(path, ""), lambda path: append(path, b""), sync):
        with pytest.raises(StorageError, match=r"absent/x: cannot be written \(No such file.*is intact$"):
            act(tmp_path / "absent" / "x")


def test_append_and_delete(tmp_path):
    append(tmp_path / "x", b"a")
    append(tmp_path / "x", b"b" * 10**6)
    assert (tmp_path / "x").read_bytes() == b"a" + b"b" * 10**6
    delete(tmp_path / "x")
    delete(tmp_path / "x")
    assert not any(tmp_path.iterdir())


def test_leftovers_of_a_killed_process_go_and_nothing_else(tmp_path):
    for name in (".x.json.k3a.tmp", ".keep", "x.tmp"):
        (tmp_path / name).touch()
    (tmp_path / ".folder.tmp").mkdir()
    remove_leftovers(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".folder.tmp", ".keep", "x.tmp"]


@pytest.fixture
def outside(tmp_path):
    """A folder with a file, and a folder `run` with a link to each."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "x.npz").write_text("mine")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "x").symlink_to(tmp_path / "outside" / "x.npz")
    (tmp_path / "run" / "below").symlink_to(tmp_path / "outside")
    return tmp_path / "outside"


def untouched(outside):
    return [(path.name, path.read_text()) for path in outside.iterdir()] == [("x.npz", "mine")]


def test_a_link_is_replaced_and_not_followed(outside, tmp_path):
    write_text(tmp_path / "run" / "x", "new")
    assert untouched(outside)
    assert not (tmp_path / "run" / "x").is_symlink()
    assert (tmp_path / "run" / "x").read_text() == "new"


def test_nothing_is_added_through_a_link(outside, tmp_path):
    (tmp_path / "run" / "y").symlink_to(outside / "made")
    for name in ("x", "y"):
        for act in (lambda path: append(path, b"more"), sync):
            with pytest.raises(InputError, match=f"{name}: is a link; accepted is a regular file"):
                act(tmp_path / "run" / name)
    assert untouched(outside)


def test_a_file_with_another_name_is_parted_from_it_first(outside, tmp_path):
    os.link(outside / "x.npz", tmp_path / "run" / "z")
    append(tmp_path / "run" / "z", b" and more")
    assert (tmp_path / "run" / "z").read_text() == "mine and more"
    assert untouched(outside)


def test_a_link_is_deleted_and_not_what_it_leads_to(outside, tmp_path):
    delete(tmp_path / "run" / "x")
    assert untouched(outside)
    assert not (tmp_path / "run" / "x").is_symlink()


def test_no_folder_below_is_a_link(outside, tmp_path):
    run = tmp_path / "run"
    below = run / "below"
    for act in (
        lambda: write_text(below / "y", "new", inside=run),
        lambda: append(below / "x.npz", b"more", inside=run),
        lambda: delete(below / "x.npz", inside=run),
        lambda: delete_others(below, set(), (".npz",), inside=run),
        lambda: names_in(below, inside=run),
        lambda: make_folder(below, inside=run),
    ):
        with pytest.raises(InputError, match="its folder below is a link; accepted is a folder"):
            act()
    assert untouched(outside)


def test_a_pipe_is_neither_waited_for_nor_written_to(tmp_path):
    os.mkfifo(tmp_path / "x")
    with pytest.raises(InputError, match="x: is a pipe"):
        append(tmp_path / "x", b"a")
    write_text(tmp_path / "x", "new")
    assert (tmp_path / "x").read_text() == "new"


def test_others_are_deleted_by_their_suffix(tmp_path):
    for name in ("a.npz", "b.npz", "c.txt", "d.md"):
        (tmp_path / name).touch()
    (tmp_path / "e.npz").mkdir()
    delete_others(tmp_path, {"a.npz"}, (".npz", ".txt"), inside=tmp_path)
    assert names_in(tmp_path, inside=tmp_path) == ["a.npz", "d.md", "e.npz"]
    assert names_in(tmp_path / "absent", inside=tmp_path) == []
