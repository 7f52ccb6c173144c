"""The native chunk, compiled and known to JAX."""

import pytest

from slcs2_jax.native.library import reason_against


@pytest.fixture(autouse=True, scope="package")
def _library() -> None:
    assert reason_against() is None
