"""Sets of rules as bits."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.policy import bits


@pytest.mark.parametrize("rules", [1, 2, 31, 32, 33, 63, 64, 65, 99, 100, 128, 1000])
@pytest.mark.parametrize("rest", [(), (3,), (2, 5)])
def test_a_set_is_unpacked_as_it_was_packed(rules, rest):
    members = jnp.asarray(np.random.default_rng(rules).random((rules, *rest)) < 0.4)
    packed = bits.pack(members)
    assert (packed.shape, packed.dtype) == ((-(-rules // 32), *rest), jnp.uint32)
    np.testing.assert_array_equal(bits.unpack(packed, rules), members)


def test_rules_are_in_stretches_of_one_length():
    packed = bits.pack(jnp.arange(100) == 51)  # the second of the third stretch of 25
    np.testing.assert_array_equal(packed, [0, 0, 2, 0])
