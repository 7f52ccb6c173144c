"""Files are whole or as they were."""

import os

import pytest

from slcs2_jax.config import StorageError
from slcs2_jax.results.files import append, delete, remove_leftovers, sync, write_text, write_whole


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
    remove_leftovers(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".keep", "x.tmp"]
