"""Mean received power: the log-distance model in closed form, what derives from it, and a user's own."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import InputError, Radio
from slcs2_jax.config.registry import KINDS, register
from slcs2_jax.world.propagation import LogDistance
from slcs2_jax.world.radio import RadioParameters


@pytest.mark.parametrize(
    "settings", [{}, {"path_loss_exponent": 3.3}, {"reference_distance": 4.0, "wall_loss_db": 7.0}]
)
def test_levels_are_the_formulas(settings):
    radio = Radio(**settings)
    distance, walls = np.array([0.5, 1.0, 30.0, 163.0, 900.0]), np.array([0.0, 1.0, 0.0, 3.0, 12.0])
    level = LogDistance.of(radio).level(jnp.asarray(distance**2, jnp.float32), jnp.asarray(walls, jnp.float32))
    d0 = radio.reference_distance
    loss = radio.reference_loss_db + 10 * radio.path_loss_exponent * np.log10(np.maximum(distance, d0) / d0)
    expected = radio.power_dbm - loss - walls * radio.wall_loss_db
    np.testing.assert_allclose(10 * np.log10(2.0) * np.asarray(level, float), expected, atol=1e-4)


def test_the_reach_is_where_the_level_is_that_of_reception():
    radio = Radio(path_loss_exponent=2.4, power_dbm=10.0)
    level = LogDistance.of(radio).level(jnp.float32(LogDistance.reach(radio) ** 2), jnp.float32(0))
    assert 10 * np.log10(2.0) * float(level) == pytest.approx(radio.receive_threshold_dbm, abs=1e-4)


def test_one_program_serves_every_exponent_and_the_network_range_follows():
    traced = []

    @jax.jit
    @jax.vmap
    def reach(exponent):
        traced.append(exponent)
        made = RadioParameters.of(SimpleNamespace(**{**vars(Radio()), "path_loss_exponent": exponent}))
        return made.network_range, made.propagation.level(made.network_range**2, jnp.float32(0))

    exponents = jnp.array([2.0, 2.8, 3.5], jnp.float32)
    ranges, levels = reach(exponents)
    np.testing.assert_allclose(ranges, [Radio(path_loss_exponent=g).network_range for g in (2.0, 2.8, 3.5)], rtol=1e-4)
    np.testing.assert_allclose(10 * np.log10(2.0) * np.asarray(levels), -82, atol=1e-3)
    reach(exponents + 0.25)
    assert len(traced) == 1


@pytest.fixture
def own():
    """Register a user's model, and forget it afterwards."""

    def add(part):
        register("propagation", "own")(part)

    yield add
    KINDS["propagation"].forget("own")


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Flat:
    """40 m of perfect reception."""

    edge: jax.Array

    @classmethod
    def of(cls, radio):
        return cls(jnp.float32(40.0))

    @staticmethod
    def reach(radio):
        return 40.0

    def level(self, squared, walls):
        return jnp.where(squared <= self.edge**2, jnp.float32(0), jnp.float32(-100)) - walls


def test_a_users_model_gives_powers_and_the_network_range(own):
    own(Flat)
    radio = Radio(propagation="own")
    assert radio.network_range == 40.0
    made = RadioParameters.of(radio)
    assert float(made.network_range) == 40.0
    assert float(made.propagation.level(jnp.float32(1500), jnp.float32(2))) == -2


@pytest.mark.parametrize(
    ("level", "says"),
    [
        (lambda self, squared, walls: squared.astype(jnp.float16), "float32"),
        (lambda self, squared, walls: squared[:3], "float32"),
        (lambda self, squared, walls: squared * np.float32(np.nan), "NaN"),
        (lambda self, squared, walls: squared / 0 * 0, "NaN"),
        (lambda self, squared, walls: None.nothing, "AttributeError"),
    ],
)
def test_a_users_model_that_does_not_work_is_named(own, level, says):
    own(jax.tree_util.register_dataclass(dataclasses.dataclass(frozen=True)(type("Bad", (Flat,), {"level": level}))))
    with pytest.raises(InputError, match=r"radio\.propagation=own of .*accepted") as caught:
        RadioParameters.of(Radio(propagation="own"))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_name_that_is_none_is_refused():
    with pytest.raises(InputError, match=r"radio\.propagation=two_ray: accepted is one of log_distance, or"):
        Radio(propagation="two_ray")
