"""The same bytes whatever the vector width, the compiler, the instruction set, the optimisation and the neighbours."""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.native import build
from slcs2_jax.policy.first_match import FirstMatch
from tests.native import elsewhere
from tests.native.episodes import ENVIRONMENTS, make
from tests.native.plain import Plain, joined, some

CELLS = [(kind, "short", "both") for kind in ENVIRONMENTS] + [(kind, "long", "main") for kind in ENVIRONMENTS]
# lanes, compiler, instruction set, further flags
USUAL = (8, "g++", "x86-64-v3", ())
VARIANTS = {
    "scalar": (1, "g++", "x86-64-v2", ("-O1",)),
    "4 lanes": (4, "g++", "x86-64-v2", ()),
    "16 lanes": (16, "g++", "x86-64-v3", ()),
    "clang": (8, "clang++", "x86-64-v3", ()),
    "clang, 16 lanes": (16, "clang++", "x86-64-v4", ("-O2",)),
    "AVX-512": (8, "g++", "x86-64-v4", ()),
}


@functools.cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="slcs2-variants-"))


@functools.cache
def compiled(lanes: int, compiler: str, level: str, flags: tuple[str, ...]) -> Path:
    """A library of one's own making."""
    path = _folder() / f"{lanes}-{compiler}-{level}{''.join(flags)}.so"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CXX", compiler)
        extra = (f"-DSLCS2_LANES={lanes}", *flags)
        build.compile_library(path, jax.ffi.include_dir(), level, extra)
    return path


def library(*how: Any) -> Plain:
    return Plain(compiled(*how))


def usual() -> Plain:
    return library(*USUAL)


@functools.cache
def played(cell: tuple[str, str, str]) -> tuple[Episode, Parameters, list[np.ndarray]]:
    """Episodes of a cell, and what the usual library makes of them."""
    environment, range_, grammar = cell
    episode, parameters = make(environment, grammar, range_=range_, seed=7)
    return episode, parameters, usual().advance(episode, parameters, 60)


def assert_same(found: list[np.ndarray], expected: list[np.ndarray]) -> None:
    for place, (one, other) in enumerate(zip(found, expected, strict=True)):
        assert one.tobytes() == other.tobytes(), f"array {place}"


def usable(variant: str) -> tuple[int, str, str, tuple[str, ...]]:
    lanes, compiler, level, flags = VARIANTS[variant]
    order, here = list(build.LEVELS), build.level() or "none"
    if here not in order or order.index(here) < order.index(level):
        level = order[0]
    return lanes, compiler if shutil.which(compiler) else "g++", level, flags


@pytest.mark.parametrize("cell", CELLS, ids=["-".join(cell) for cell in CELLS])
@pytest.mark.parametrize("variant", VARIANTS)
def test_every_way_of_compiling_gives_the_same_bytes(variant: str, cell: tuple[str, str, str]) -> None:
    episode, parameters, expected = played(cell)
    assert_same(library(*usable(variant)).advance(episode, parameters, 60), expected)


def test_neighbours_and_batch_width_change_nothing() -> None:
    episode, parameters, expected = played(CELLS[3])
    order = np.random.default_rng(0).permutation(episode.state.t.shape[0])[:11]
    found = usual().advance(some(episode, order), parameters, 60)
    assert_same(found, [array[..., order] for array in expected])


def test_cut_into_chunks_it_is_the_same() -> None:
    episode, parameters, expected = played(CELLS[3])
    for periods in (1, 20, 39):
        episode = joined(usual().advance(episode, parameters, periods), episode)
    assert_same(usual().advance(episode, parameters, 0), expected)


@pytest.mark.parametrize("variant", ["scalar", "16 lanes"])
@pytest.mark.parametrize("agents", [2, 37, 64])
def test_any_swarm_gives_the_same_bytes(variant: str, agents: int) -> None:
    episode, parameters = make("urban_jammed", "both", agents=agents, rules=37, batch=5)
    expected = usual().advance(episode, parameters, 10)
    assert_same(library(*usable(variant)).advance(episode, parameters, 10), expected)


def test_a_decision_list_gives_the_same_bytes() -> None:
    episode, parameters = make("urban_jammed", "both", rules=20, policy=FirstMatch())
    expected = usual().advance(episode, parameters, 20)
    assert_same(library(*usable("scalar")).advance(episode, parameters, 20), expected)


@pytest.mark.parametrize(("period", "depth"), [(1, 20), (7, 0), (33, 24), (10, 24)])
def test_any_sharing_period_and_memory_give_the_same_bytes(period: int, depth: int) -> None:
    learning = {"bp_max": depth, "alpha_q_final": 0.05}
    episode, parameters = make("open", "main", sharing_period=period, learning=learning)
    expected = usual().advance(episode, parameters, 6)
    assert_same(library(*usable("scalar")).advance(episode, parameters, 6), expected)


def test_figures_at_the_end_are_the_same_bytes() -> None:
    episode, parameters = make("open", "main", time_limit=95)
    over = joined(usual().advance(episode, parameters, 12), episode)
    assert_same(library(*usable("scalar")).finish(over, parameters), usual().finish(over, parameters))


@pytest.mark.slow
def test_the_program_for_emulated_processors_comes_to_the_same_on_this_one(tmp_path, monkeypatch) -> None:
    """What `scripts/emulate` runs elsewhere."""
    monkeypatch.setattr(elsewhere, "CASES", elsewhere.CASES[1:3])
    source, program = Path(elsewhere.__file__).with_suffix(".cc"), tmp_path / "program"
    flags = ["-std=c++17", "-O1", "-fno-math-errno", "-ffp-contract=off", "-Wno-psabi", "-DSLCS2_WITHOUT_XLA"]
    headers = Path(build.__file__).parent
    subprocess.run(["g++", *flags, "-I", headers, source, "-o", program], check=True)
    assert elsewhere.main(str(compiled(*USUAL)), str(program)) == 0
