"""Compiling: what is refused, and that nothing half-made is ever left."""

from __future__ import annotations

import os
from pathlib import Path

import jax
import pytest

from slcs2_jax.native import build, library
from slcs2_jax.native.build import BuildError


@pytest.fixture
def fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A compiler that does as a shell script says."""

    def make(script: str) -> None:
        path = tmp_path / "compiler"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        monkeypatch.setenv("CXX", str(path))

    return make


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(BuildError, match=r"there is no C\+\+ compiler \(CXX=no-such-compiler\)"):
        build.compiler()
    monkeypatch.delenv("CXX")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(BuildError, match=r"c\+\+, g\+\+ or clang\+\+"):
        build.compiler()


def test_a_broken_compiler_is_told_in_one_line_and_leaves_nothing(tmp_path: Path, fake) -> None:
    fake("echo note >&2; echo 'x.cc:1: error: it is broken' >&2; exit 1")
    with pytest.raises(BuildError, match=r"fails \(x.cc:1: error: it is broken\)") as found:
        build.compile_library(tmp_path / "out" / "chunk.so", jax.ffi.include_dir(), None)
    assert "\n" not in str(found.value)
    assert list((tmp_path / "out").iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BuildError, match="file"):
        build.compile_library(tmp_path / "file" / "chunk.so", jax.ffi.include_dir(), None)


def test_a_library_is_compiled_once_and_named_by_what_it_is_made_of(tmp_path: Path, fake) -> None:
    fake(f'echo x >> {tmp_path}/calls; for last; do :; done; [ "$1" = --version ] && echo 1 || echo made > "$last"')
    first = build.cached_library(tmp_path / "cache", "include", "jaxlib 1")
    assert first.read_text() == "made\n"
    before = (tmp_path / "calls").read_text()
    assert build.cached_library(tmp_path / "cache", "include", "jaxlib 1") == first
    assert len((tmp_path / "calls").read_text()) == len(before) + 2, "only its version is asked for again"
    assert build.cached_library(tmp_path / "cache", "include", "jaxlib 2") != first
    fake("echo 2")
    assert [path.name for path in (tmp_path / "cache").iterdir() if path.suffix != ".so"] == []


def test_a_library_of_another_version_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "chunk.so"
    with monkeypatch.context() as patch:
        patch.setattr(build, "source_key", lambda: "another")
        build.compile_library(path, jax.ffi.include_dir(), build.level(), ("-O0",))
    with pytest.raises(BuildError, match="of another version"):
        library.register(path)


@pytest.mark.parametrize("content", [b"", b"no library", os.urandom(5000)])
def test_what_is_no_library_is_told(content: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "chunk.so"
    path.write_bytes(content)
    monkeypatch.setattr(library, "_find", lambda: path)
    library.reason_against.cache_clear()
    reason = library.reason_against()
    library.reason_against.cache_clear()
    assert reason is not None
    assert "chunk.so" in reason
    assert "\n" not in reason


def test_what_the_wheel_carries_is_known_by_its_label(tmp_path: Path, fake, monkeypatch: pytest.MonkeyPatch) -> None:
    fake('for last; do :; done; echo made > "$last"')
    made = build.prebuild(tmp_path / "lib", "include", f"jaxlib {library.jaxlib.__version__}")
    monkeypatch.setattr(build, "PREBUILT", tmp_path / "lib")
    installed = tmp_path / "lib" / build.installed_name(build.level())
    assert installed in made
    assert library._find() == installed
    installed.with_suffix(".txt").write_text("of another version")
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(BuildError, match="no C"):
        library._find()
