"""One process per folder, and nothing in the way once that process is gone."""

import errno
import fcntl
import json
import os
import resource
import signal
import subprocess
import sys

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.results import lock
from slcs2_jax.results.lock import LOCK, FolderLock

HOLD = """\
import pathlib, sys, time
from slcs2_jax.results.lock import FolderLock
held = FolderLock(pathlib.Path(sys.argv[1]))
print("held", flush=True)
time.sleep(60)
"""


def test_another_process_is_refused_until_it_is_dead(tmp_path):
    with subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        with pytest.raises(InputError, match=f"run_dir=.*: process {process.pid} on .* works in it since .*"):
            FolderLock(tmp_path)
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert (tmp_path / LOCK).exists()
    with FolderLock(tmp_path):
        assert json.loads((tmp_path / LOCK).read_text())["pid"] == os.getpid()
    assert not (tmp_path / LOCK).exists()


def test_twice_in_one_process(tmp_path):
    with FolderLock(tmp_path), pytest.raises(InputError, match=f"process {os.getpid()} on"):
        FolderLock(tmp_path)
    held = FolderLock(tmp_path)
    held.release()
    held.release()


def test_a_file_that_was_removed_meanwhile_is_no_lock(tmp_path, monkeypatch):
    """Whoever waited for the file of a process that removed it must not believe to hold the new one's."""
    opened = lock._open
    times = []

    def open_then_lose(path):
        handle = opened(path)
        if not times:
            path.unlink()
        times.append(handle)
        return handle

    monkeypatch.setattr(lock, "_open", open_then_lose)
    with FolderLock(tmp_path):
        assert len(times) == 2
        assert (tmp_path / LOCK).exists()


@pytest.mark.parametrize(
    ("owner", "accepted"),
    [
        ({"host": "elsewhere", "pid": 1}, False),
        ({"host": None, "pid": os.getpid()}, False),
        ({"host": None, "pid": 2**22 + 5}, True),  # no such process
        ({}, True),
        ("not JSON", True),
    ],
)
def test_where_the_file_system_has_no_locks_the_record_decides(tmp_path, monkeypatch, owner, accepted):
    def flock(handle: int, operation: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)
    if isinstance(owner, dict) and "host" in owner:
        owner["host"] = owner["host"] or lock.socket.gethostname()
    (tmp_path / LOCK).write_text(owner if isinstance(owner, str) else json.dumps(owner))
    if accepted:
        FolderLock(tmp_path).release()
    else:
        with pytest.raises(InputError, match=r"if that process is dead, delete .*lock"):
            FolderLock(tmp_path)


def test_hundreds_of_runs_take_more_files_than_are_usual(tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < 400:
        pytest.skip("the system allows no more")
    resource.setrlimit(resource.RLIMIT_NOFILE, (200, hard))
    try:
        held = []
        for number in range(300):
            folder = tmp_path / str(number)
            folder.mkdir()
            held.append(FolderLock(folder))
        for one in held:
            one.release()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.parametrize("kind", ["link", "link to nothing", "another name", "pipe", "folder", "large"])
def test_what_is_no_lock_of_ours_is_refused_and_nothing_written_through_it(kind, tmp_path):
    mine, run = tmp_path / "mine", tmp_path / "run"
    mine.write_text("mine")
    run.mkdir()
    place = run / LOCK
    {
        "link": lambda: place.symlink_to(mine),
        "link to nothing": lambda: place.symlink_to(tmp_path / "made"),
        "another name": lambda: os.link(mine, place),
        "pipe": lambda: os.mkfifo(place),
        "folder": place.mkdir,
        "large": lambda: place.write_bytes(bytes(5000)),
    }[kind]()
    with pytest.raises(InputError, match=r"run/lock: is .*; delete it$"):
        FolderLock(run)
    assert not lock.is_held(run)
    assert mine.read_text() == "mine"
    assert not (tmp_path / "made").exists()


def test_the_module_is_there_without_the_systems_own(tmp_path):
    """As on Windows, where there is no fcntl and no resource."""
    code = (
        "import sys, types, pathlib, slcs2_jax.results; "
        "sys.modules |= {'fcntl': None, 'resource': None}; del sys.modules['slcs2_jax.results.lock']; "
        "sys.platform = 'win32'; m = types.ModuleType('msvcrt'); m.LK_NBLCK = 2; m.locking = lambda *_: None; "
        "sys.modules['msvcrt'] = m; import importlib; "
        "lock = importlib.import_module('slcs2_jax.results.lock'); "
        "held = lock.FolderLock(pathlib.Path(sys.argv[1])); "
        "assert lock.is_held(pathlib.Path(sys.argv[1])); held.release()"
    )
    subprocess.run([sys.executable, "-c", code, tmp_path], check=True)
    assert not (tmp_path / LOCK).exists()
