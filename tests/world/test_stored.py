"""Storing changes nothing but where a value lives."""

import re

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.world.stored import stored

X = jnp.linspace(-2, 2, 1024, dtype=jnp.float32)


def sines(x, witness, keep):
    slow = jnp.sin(x)
    slow = stored(slow, witness) if keep else slow
    return jnp.stack([slow[k:] @ slow[: 1024 - k] for k in (1, 2, 3)]), slow + 1, slow * 2


def test_values_of_every_type_pass_unchanged_alone_and_in_batches():
    tree = (X, jnp.arange(3), X > 0, {"nothing": jnp.zeros((0, 2), jnp.uint8)})
    for kept in (stored(tree, jnp.float32(0)), jax.jit(stored)(tree, jnp.float32(3))):
        jax.tree.map(np.testing.assert_array_equal, kept, tree)
    batch = jnp.stack([X, -X], axis=-1)
    alike = jax.vmap(stored, in_axes=(-1, None), out_axes=-1)(batch, jnp.float32(0))
    np.testing.assert_array_equal(alike, batch)


def test_on_a_cpu_a_stored_value_is_computed_once():
    def count(keep):
        text = jax.jit(sines, static_argnums=2).lower(X, jnp.float32(0), keep).compile().as_text()
        return len(re.findall(r" sine\(", text))

    assert count(True) == 1 < count(False)


def test_on_a_gpu_there_is_no_choice_between_branches():
    def text(platform):
        return jax.jit(stored).trace(X, jnp.float32(0)).lower(lowering_platforms=(platform,)).as_text()

    assert "compare" in text("cpu")
    assert "compare" not in text("cuda")
