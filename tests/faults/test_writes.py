"""The disk refuses at one call or another: the error is one line, and the run goes on as if nothing had happened."""

from __future__ import annotations

import errno
import os

import pytest

from slcs2_jax.config import StorageError
from slcs2_jax.results import files
from slcs2_jax.running import driver

CALLS = ("open", "write", "fsync", "replace")
FAULTS = {  # which call, and what becomes of it
    "no space": ("write", errno.ENOSPC),
    "half written, then no space": ("write", -errno.ENOSPC),
    "input/output error": ("fsync", errno.EIO),
    "no rename": ("replace", errno.EACCES),
    "read-only": ("open", errno.EROFS),
}


class FaultyOs:
    """The module os, but that one of its calls fails once: the `at`-th one of the given name."""

    def __init__(self, name: str = "", at: int = -1, number: int = 0) -> None:
        self.name, self.at, self.number = name, at, number
        self.made = dict.fromkeys(CALLS, 0)

    def __getattr__(self, name: str):
        function = getattr(os, name)
        return self._counting(name, function) if name in CALLS else function

    def _counting(self, name: str, function):
        def call(*arguments, **keywords):
            self.made[name] += 1
            if name == self.name and self.made[name] == self.at:
                if self.number < 0:  # part of it arrives
                    os.write(arguments[0], bytes(arguments[1][: len(arguments[1]) // 2]))
                raise OSError(abs(self.number), os.strerror(abs(self.number)))
            return function(*arguments, **keywords)

        return call


@pytest.fixture(scope="module")
def calls(tiny_run, tmp_path_factory) -> dict[str, int]:
    """How often each call is made in a whole run."""
    counting = FaultyOs()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "os", counting)
        driver.evolve([tiny_run.settings(tmp_path_factory.mktemp("calls") / "run")])
    return counting.made


@pytest.mark.parametrize("fault", FAULTS)
def test_every_write_may_fail(fault, calls, tiny_run, finished, tmp_path, monkeypatch):
    name, number = FAULTS[fault]
    every = int(os.environ.get("SLCS2_FAULTS_EVERY", "4"))
    expected = tiny_run.results(finished)
    assert calls[name] >= 20
    for at in range(1, calls[name] + 1, every):
        folder = tmp_path / f"run_{at}"
        settings = tiny_run.settings(folder)
        monkeypatch.setattr(files, "os", FaultyOs(name, at, number))
        with pytest.raises(StorageError, match=r"cannot be (written|deleted) \(.*; what was saved before") as error:
            driver.evolve([settings])
        assert "\n" not in str(error.value)
        assert str(folder) in str(error.value)
        monkeypatch.setattr(files, "os", os)
        driver.evolve([settings])
        assert tiny_run.results(folder) == expected, f"{name} {at}"


def test_a_write_that_takes_a_part_at_a_time_is_finished(tiny_run, finished, tmp_path, monkeypatch):
    class Slow(FaultyOs):
        def write(self, handle: int, data: memoryview) -> int:
            return os.write(handle, data[: max(1, len(data) // 3)])

    monkeypatch.setattr(files, "os", Slow())
    driver.evolve([tiny_run.settings(tmp_path / "run")])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder(tiny_run, tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(Exception, match="cannot be written to; accepted is a folder that can"):
        driver.evolve([tiny_run.settings(tmp_path / "run")])
