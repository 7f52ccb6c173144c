"""Settings: types, limits, what must hold between fields, and one-line messages."""

import dataclasses
import math
import subprocess
import sys
from pathlib import PurePosixPath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slcs2_jax.config import (
    Compute,
    InputError,
    Jammers,
    Learning,
    Radio,
    Search,
    Settings,
    Swarm,
    World,
    settings_from,
    settings_table,
    settings_to_dict,
)
from slcs2_jax.config.field import STATUS_MEANING, described
from slcs2_jax.config.settings import SECTIONS


def message(make) -> str:
    with pytest.raises(InputError) as caught:
        make()
    text = str(caught.value)
    assert "\n" not in text
    assert "accepted" in text
    return text


def test_defaults_are_the_specifications():
    settings = Settings()
    assert settings.radio.network_range == pytest.approx(163.12, abs=0.01)
    assert (settings.swarm.agents, settings.swarm.packets, settings.swarm.speed) == (12, 150, 2.0)
    assert (settings.world.distance, settings.world.time_limit) == (600.0, 20_000)
    assert (settings.learning.beta_q, settings.learning.bp_max) == (0.71, 20)
    assert (settings.rules.rules, settings.rules.codons, settings.search.generations) == (100, 40, 500)


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: Radio(noise_dbm=math.nan), "radio.noise_dbm=nan: accepted is a finite number from -200 to 200"),
        (lambda: Radio(power_dbm=math.inf), "radio.power_dbm=inf: accepted is a finite number from -200 to 200"),
        (lambda: Radio(noise_dbm="loud"), "radio.noise_dbm=loud: accepted is a finite number from -200 to 200"),
        (lambda: Swarm(agents=1), "swarm.agents=1: accepted is a whole number from 2 to 64"),
        (lambda: Swarm(agents=65), "swarm.agents=65: accepted is a whole number from 2 to 64"),
        (lambda: Swarm(agents=12.0), "swarm.agents=12.0: accepted is a whole number from 2 to 64"),
        (lambda: Swarm(agents=True), "swarm.agents=true: accepted is a whole number from 2 to 64"),
        (lambda: Swarm(clearance=7e-188), "swarm.clearance=7e-188: accepted is a finite number from 0.0001 to 1000"),
        (lambda: Swarm(speed=0), "swarm.speed=0: accepted is a finite number from 0.0001 to 1000"),
        (lambda: Swarm(packets=-3), "swarm.packets=-3: accepted is a whole number from 1 to 1000000"),
        (lambda: Learning(beta_q=1.0), "learning.beta_q=1.0: accepted is a finite number >= 0 and < 1"),
        (lambda: Learning(alpha_q=-0.1), "learning.alpha_q=-0.1: accepted is a finite number from 0 to 1"),
        (lambda: Learning(bp_max=25), "learning.bp_max=25: accepted is a whole number from 0 to 24"),
        (lambda: Search(generations=0), "generations=0: accepted is a whole number from 1 to 10000000"),
        (
            lambda: Search(acceptance="novel"),
            "acceptance=novel: accepted is one of domination, ailta, best, map_elites, dominated_novelty, or a name "
            "that plugins= brings",
        ),
        (lambda: Search(exchange="maybe"), "exchange=maybe: accepted is true or false"),
        (lambda: Compute(devices=0), "compute.devices=0: accepted is a whole number from 1 to 1024 or null"),
        (lambda: Settings(seed=-1), "seed=-1: accepted is a whole number from 0 to 2147483647"),
        (lambda: Settings(run_dir=""), "run_dir=: accepted is a text or null"),
        (
            lambda: Settings(seed=10**5000),
            "seed=(too long to be shown): accepted is a whole number from 0 to 2147483647",
        ),
        (lambda: Swarm(agents=np.True_), f"swarm.agents={np.True_!r}: accepted is a whole number from 2 to 64"),
        (lambda: Swarm(packets={}), "swarm.packets={}: accepted is a whole number from 1 to 1000000"),
        (lambda: Swarm(packets=[3]), "swarm.packets=[3]: accepted is a whole number from 1 to 1000000"),
        (lambda: Search(exchange=1), "exchange=1: accepted is true or false"),
        (lambda: Settings(run_dir=PurePosixPath("x")), "run_dir=PurePosixPath('x'): accepted is a text or null"),
        (
            lambda: dataclasses.replace(World.preset("urban"), distance=1e6, building_spacing=0.01),
            "world.building_spacing=0.01: accepted is a number from 166.667 with world.distance=1e+06, "
            "for at most 6,000 buildings",
        ),
        (
            lambda: World(environment="forest"),
            "environment=forest: accepted is one of open, jammed, urban, urban_jammed",
        ),
    ],
)
def test_one_line_names_the_field_its_value_and_what_is_accepted(make, expected):
    assert message(make) == expected


def test_no_place_for_the_jammer():
    world = dataclasses.replace(World.preset("jammed", "short"), distance=326.0)
    assert "no place for the jammer" in message(lambda: Settings(world=world))
    assert Settings(world=dataclasses.replace(world, distance=327.0)).world.jammer
    assert Settings(world=World(distance=10.0)).world.distance == 10.0  # without a jammer any distance will do


def test_no_place_for_the_agents():
    crowded = message(lambda: Settings(swarm=Swarm(agents=64), world=World(start_radius=10)))
    assert crowded.startswith("swarm.agents=64: no place for the agents: accepted is at most 48")
    assert Settings(swarm=Swarm(agents=48), world=World(start_radius=10)).swarm.agents == 48


def test_what_must_agree():
    assert message(lambda: World(jammer=True)).startswith("world.jammer=true: accepted is false with environment=open")
    assert "world.building_max" in message(lambda: World(building_min=40))
    assert "world.building_spacing" in message(lambda: dataclasses.replace(World.preset("urban"), distance=5.0))
    assert "network range" in message(lambda: Radio(path_loss_exponent=1e-3))


def test_words_and_whole_numbers_are_taken_where_they_are_exact():
    assert Search(exchange="off").exchange is False
    assert Swarm(speed=3).speed == 3.0
    assert isinstance(Swarm(speed=3).speed, float)
    assert Learning(alpha_q_final=None).alpha_q_final is None


@pytest.mark.parametrize("section", SECTIONS.values())
def test_every_setting_is_documented(section):
    for field in described(section):
        assert field.doc.help
        assert field.doc.status in STATUS_MEANING
        if field.doc.status in ("assumed", "calibrated"):
            assert field.doc.reason, f"{field.name} needs its reason"
        if field.kind in (int, float):
            assert field.doc.low is not None, f"{field.name} needs a lower bound"
            assert field.doc.high is not None, f"{field.name} needs an upper bound"


NUMBERS = [(kind, f) for kind in SECTIONS.values() for f in described(kind) if f.kind in (int, float)]


@given(st.sampled_from(NUMBERS), st.one_of(st.floats(), st.integers(), st.text(max_size=5), st.none(), st.booleans()))
def test_a_number_field_holds_a_number_within_its_bounds_or_is_refused(chosen, value):
    kind, field = chosen
    try:
        held = getattr(kind(**{field.attribute: value}), field.attribute)
    except InputError:
        message(lambda: kind(**{field.attribute: value}))
        return
    if held is None:
        assert field.optional
    else:
        assert type(held) is field.kind
        assert field.doc.low <= held <= field.doc.high


def test_table_has_a_row_for_every_setting():
    rows = {row.name: row for row in settings_table()}
    assert rows["radio.path_loss_exponent"].status == "calibrated"
    assert rows["generations"].value == "500"
    assert len(rows) == len(settings_table())


def test_importing_the_configuration_starts_neither_jax_nor_hydra():
    code = (
        "import sys, slcs2_jax.config; print([m for m in ('jax', 'hydra', 'omegaconf', 'numpy') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown.strip() == "[]"


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: Radio(channels=[]), "radio.channels=[]: accepted is a list of 1 to 14 different whole numbers"),
        (lambda: Radio(channels=(1, 6, 1)), "radio.channels=[1,6,1]: accepted is a list of 1 to 14 different"),
        (
            lambda: Radio(channels=[0]),
            "radio.channels=[0]: accepted is a list of 1 to 14 different whole numbers from 1",
        ),
        (lambda: Radio(channels=[1.0]), "radio.channels=[1.0]: accepted is a list"),
        (lambda: Radio(channels=[True]), "radio.channels=[True]: accepted is a list"),
        (lambda: Radio(channels="1,6"), "radio.channels=1,6: accepted is a list"),
        (lambda: Radio(channels=7), "radio.channels=7: accepted is a list"),
        (lambda: Swarm(failures_at=None), "swarm.failures_at=null: accepted is a list of 0 to 100 different"),
        (lambda: Radio(fading="foggy"), "radio.fading=foggy: accepted is one of none, lognormal, rayleigh, rician"),
        (lambda: Jammers(motion="up"), "jammers.motion=up: accepted is one of fixed, patrol, pursue, or a name that"),
        (lambda: Jammers(count=0), "jammers.count=0: accepted is a whole number from 1 to 16"),
    ],
)
def test_lists_and_parts_are_refused_in_the_same_form(make, expected):
    assert message(make).startswith(expected)


def test_a_list_of_numbers_is_held_as_a_tuple_and_written_as_a_list():
    settings = Settings(radio=Radio(channels=[11, 1]), swarm=Swarm(failures_at=[5]))
    assert settings.radio.channels == (11, 1)
    plain = settings_to_dict(settings)
    assert plain["radio"]["channels"] == [11, 1]
    assert settings_from(plain) == settings
    assert hash(settings) == hash(settings_from(plain))
