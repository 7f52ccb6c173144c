"""Strictness for every test: JAX on two CPU devices, no silent promotion of dtypes; and see pyproject.toml."""

import os

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import hypothesis
import jax

jax.config.update("jax_num_cpu_devices", 2)
jax.config.update("jax_numpy_dtype_promotion", "strict")
# Ranks may differ on purpose: the batch is the last axis and [B] meets [n, B].

hypothesis.settings.register_profile("slcs2", deadline=None, max_examples=50, print_blob=True)
hypothesis.settings.load_profile("slcs2")
