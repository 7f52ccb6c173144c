"""What users' parts return is checked, and the view's shortcuts are the state's own."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.swarm.view import checked

AGENTS = jax.ShapeDtypeStruct((4, 3), np.float32)


@pytest.mark.parametrize("shape", [(4, 3), (), (1,), (3,), (4, 1)])
def test_what_fits_is_spread_to_every_agent(shape):
    value = np.arange(np.prod(shape, dtype=int), dtype=np.float32).reshape(shape)
    found = checked("reward", "mine", jnp.asarray(value), AGENTS, "float32")
    assert (found.shape, found.dtype) == ((4, 3), np.float32)
    np.testing.assert_array_equal(found, np.broadcast_to(value, (4, 3)))


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (jnp.zeros((4, 3), bool), "bool[4, 3]"),
        (jnp.zeros((4, 3), jnp.int32), "int32[4, 3]"),
        (jnp.zeros((3, 4), jnp.float32), "float32[3, 4]"),
        (jnp.zeros(4, jnp.float32), "float32[4]"),
        (jnp.zeros((2, 4, 3), jnp.float32), "float32[2, 4, 3]"),
        (1.0, "float"),
        (None, "NoneType"),
        ([1.0, 2.0], "list"),
    ],
)
def test_what_does_not_fit_is_named_in_one_line(value, told):
    with pytest.raises(InputError) as found:
        checked("reward", "mine", value, AGENTS, "float32")
    assert str(found.value) == f"reward 'mine': returned {told}; accepted is float32[4, 3]"


def test_flags_are_flags():
    with pytest.raises(InputError, match=r"^clause 'near': returned float32\[2\]; accepted is bool\[2\]$"):
        checked("clause", "near", jnp.ones(2), jnp.zeros(2), bool)


def test_shortcuts(make):
    state, links, arena = make.view(np.random.default_rng(3))
    view = make.look(state, links, arena, make.physics())
    np.testing.assert_array_equal(view.x, state.x)
    np.testing.assert_array_equal(view.y, state.y)
    np.testing.assert_array_equal(view.holding, state.holding)
    np.testing.assert_array_equal(view.heard, links.heard)
    assert view.running
    assert (len(view.left), len(view.right)) == (5, 6)
