"""Random settings, random texts, random bytes: never a traceback, never a wrong file that is believed.

SLCS2_INPUTS sets how many inputs each test tries; those that run a swarm try a thousandth of it.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.config import InputError, Learning, Radio, Search, Settings, Swarm, World, settings_from
from slcs2_jax.config.schema import settings_fields, settings_to_dict
from slcs2_jax.grammar import decode_rule, load_grammar, parse_grammar
from slcs2_jax.results.archive import read_archive
from slcs2_jax.results.documents import read_document
from slcs2_jax.results.lock import FolderLock
from slcs2_jax.results.reading import read_run
from slcs2_jax.results.rows import read_rows
from slcs2_jax.results.run_config import read_config
from slcs2_jax.results.run_folder import CHECKPOINT, CHECKPOINT_FORMAT, CONFIG, GENERATIONS, SUMMARY
from slcs2_jax.results.saved import load_solution
from slcs2_jax.results.sweep import SWEEP, runs_below, write_sweep
from slcs2_jax.running import driver
from tests.faults.spoiling import INPUTS, many, one_line, spoilt

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

import fault_campaign_files as files

OTHERS = "others"  # folder of what is no run's

some = settings(max_examples=max(5, INPUTS // 1000))


# -- settings ----------------------------------------------------------------------------------------------------------


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


WORLDS = st.builds(
    World,
    distance=numbers(20, 2000),
    time_limit=st.integers(1, 80),
    strip_half_width=numbers(0, 300),
    start_radius=numbers(20, 100),
)
RADIOS = st.builds(
    Radio,
    power_dbm=numbers(-10, 40),
    half_power_db=numbers(-20, 0),
    reference_loss_db=numbers(20, 60),
    path_loss_exponent=numbers(1.5, 5),
    shadowing_db=numbers(0, 20),
    noise_dbm=numbers(-150, -50),
    receive_threshold_dbm=numbers(-120, -40),
    sinr_threshold_db=numbers(-20, 40),
)
SWARMS = st.builds(
    Swarm,
    agents=st.just(3),
    packets=st.integers(1, 50),
    speed=numbers(2**-10, 100),
    clearance=numbers(2**-10, 10),
    lidar_range=numbers(2**-10, 1000),
    distance_threshold=numbers(2**-10, 1000),
    tolerance=numbers(0, 1),
    sink_error=numbers(0, 500),
)
LEARNING = st.builds(
    Learning,
    alpha_grasp=numbers(0, 1),
    alpha_q=numbers(0, 1),
    alpha_q_final=st.none() | numbers(0, 1),
    beta_q=numbers(0, 0.99),
    trace_decay=numbers(0, 1),
    cost_move=numbers(0, 1e6),
    cost_communicate=numbers(0, 1e6),
)
SEARCHES = st.builds(
    Search,
    generations=st.integers(1, 4),
    acceptance=st.sampled_from(["domination", "ailta"]),
    exchange=st.booleans(),
    min_deployments=st.integers(1, 3),
    max_redeployments=st.integers(0, 3),
    omega0=numbers(0, 1e6),
    varrho=numbers(2**-10, 1e9),
    fresh_deployments=st.integers(1, 3),
)


@pytest.mark.slow
@some
@given(world=WORLDS, radio=RADIOS, swarm=SWARMS, learning=LEARNING, search=SEARCHES, seed=st.integers(0, 2**31 - 2))
def test_any_settings_within_the_limits_run_and_keep_what_must_hold(
    world, radio, swarm, learning, search, seed, tiny_run, tmp_path_factory
):
    run_dir = tmp_path_factory.mktemp("any") / "run"
    values = {"world": world, "radio": radio, "swarm": swarm, "learning": learning, "search": search, "seed": seed}
    try:
        one = dataclasses.replace(tiny_run.settings(run_dir), **values)
    except InputError:  # a network range beyond all limits, no place for the agents
        return
    [summary] = driver.evolve([one])
    assert [instance.generations for instance in summary.instances] == [search.generations] * 2
    run = read_run(run_dir)
    assert len(run.rows) == 2 * search.generations
    for row in run.rows:
        assert -1 <= row["fitness"] <= row["best"] <= 1
        assert 0 <= row["delivered"] <= swarm.packets
        assert 0 <= row["steps"] <= world.time_limit
        assert row["steps"] == world.time_limit or row["delivered"] > 0
        assert all(0 <= share <= row["delivered"] for share in row["contribution"])
        assert search.min_deployments <= row["deployments"] <= max(search.min_deployments, 1 + search.max_redeployments)
    for instance in range(2):
        for solution in (run.best(instance), *run.members(instance)):
            assert (solution.usage.sum(axis=1) <= world.time_limit * 6).all()


@pytest.fixture(scope="module")
def defaults() -> dict:
    return settings_to_dict(Settings())


VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.sampled_from(["nan", "inf", "-1", "1e400", "0x10", "off"]),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
)
NAMES = st.sampled_from([field.name for _, field in settings_fields()]) | st.text(max_size=12)


@many
@given(changes=st.dictionaries(NAMES, VALUES, min_size=1, max_size=3))
def test_any_value_of_any_setting_is_checked(changes, defaults):
    mapping = {key: dict(value) if isinstance(value, dict) else value for key, value in defaults.items()}
    for name, value in changes.items():
        section, _, last = name.rpartition(".")
        inner = mapping.setdefault(section, {}) if section else mapping
        if isinstance(inner, dict):  # else the section's name is that of a setting, and holds nothing
            inner[last] = value
    try:
        made = settings_from(mapping)
    except InputError as error:
        one_line(error)
        return
    for section, field in settings_fields():
        value = getattr(getattr(made, section) if section else made, field.attribute)
        assert not field.is_list or isinstance(value, tuple)
        for entry in value if field.is_list else () if value is None else (value,):
            assert type(entry) is field.kind
            assert field.kind is not float or math.isfinite(entry)
    assert settings_from(settings_to_dict(made)) == made


# -- grammars ----------------------------------------------------------------------------------------------------------

WORDS = {*load_grammar("both").text.split(), *load_grammar("main").text.split(), "'", '"', "#", "%", "11", "\n"}
PIECES = st.sampled_from(sorted(WORDS))
GRAMMARS = st.one_of(
    st.text(max_size=300),
    st.lists(PIECES, max_size=60).map(" ".join),
    st.binary(max_size=200).map(lambda data: data.decode("latin-1")),
)


@many
@given(text=GRAMMARS, codons=st.lists(st.integers(0, 255), min_size=1, max_size=20))
def test_any_text_as_a_grammar_is_refused_or_works(text, codons):
    try:
        grammar = parse_grammar(text)
    except InputError as error:
        one_line(error)
        return
    rule = decode_rule(grammar, codons)
    assert set(rule.clauses) <= set(grammar.clauses)
    assert rule.action in grammar.actions
    assert rule.text()


# -- files -------------------------------------------------------------------------------------------------------------


def solution(path):
    one = vars(load_solution(path)).copy()
    rules = one.pop("rules")
    arrays = {"mask": rules.mask, "action": rules.action} | one
    return {name: value.tobytes() if isinstance(value, np.ndarray) else value for name, value in arrays.items()}


def checkpoint(path):
    arrays, about = read_archive(path, CHECKPOINT_FORMAT)
    return {name: array.tobytes() for name, array in arrays.items()}, about


def configuration(path):
    config = read_config(path.parent)
    return config.settings, config.record


READERS: dict[str, Callable[[Path], object]] = {
    "solutions/instance_000_best.npz": solution,
    CHECKPOINT: checkpoint,
    CONFIG: configuration,
    GENERATIONS: read_rows,
    SUMMARY: lambda path: read_document(path, "summary", 1),
    SWEEP: lambda path: runs_below(path.parent),
    **{f"{OTHERS}/{name}": read for name, read in files.READERS.items()},
}
MAY_END_EARLY = (GENERATIONS, f"{OTHERS}/{files.DEPLOYMENTS}")


@pytest.fixture(scope="module")
def whole(finished, tmp_path_factory) -> dict[str, bytes]:
    """The bytes of every kind of file."""
    folder = tmp_path_factory.mktemp("sweep")
    write_sweep(folder, [dataclasses.replace(read_run(finished).settings, run_dir=str(folder / "run"))])
    files.write_files(folder / OTHERS)
    return {name: (place if (place := folder / name).exists() else finished / name).read_bytes() for name in READERS}


@pytest.mark.parametrize("name", READERS)
def test_any_bytes_as_a_file_are_refused_or_mean_the_same(name, whole, tmp_path):
    for other in whole if name.startswith(OTHERS) else (name,):  # of a training the curve and the checkpoint are read
        (tmp_path / other).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / other).write_bytes(whole[other])
    path = tmp_path / name
    right = READERS[name](path)
    for number in range(INPUTS):
        path.write_bytes(spoilt(whole[name], number))
        try:
            found = READERS[name](path)
        except InputError as error:
            one_line(error)
            continue
        # rows at the end may be missing: of a run that goes on they may be still to come, and one that ended is counted
        early = name in MAY_END_EARLY and list(found) == list(right)[: len(found)]
        assert found == right or early, f"spoilt by number {number}"


@many
@given(data=st.binary(max_size=100))
def test_any_bytes_in_a_lock_that_nobody_holds_are_written_over(data, tmp_path_factory):
    folder = tmp_path_factory.getbasetemp()
    (folder / "lock").write_bytes(data)
    with FolderLock(folder), pytest.raises(InputError, match="works in it"):
        FolderLock(folder)
    assert not (folder / "lock").exists()
