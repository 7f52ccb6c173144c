"""The builders of the search's tests."""

from tests.search.conftest import make

__all__ = ["make"]
