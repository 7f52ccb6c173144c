"""What acceptances have in common that hold members in the order in which they came."""

from __future__ import annotations

from typing import Any

from slcs2_jax.search.member import Member


class Held:
    """Members, and nothing besides."""

    def __init__(self) -> None:
        self._members: list[Member] = []

    def members(self) -> list[Member]:
        """The members, oldest first."""
        return list(self._members)

    def state(self) -> dict[str, Any]:
        """Nothing besides the members is remembered."""
        return {}

    def restore(self, members: list[Member], state: dict[str, Any]) -> None:
        """Hold exactly these members, in this order."""
        self._members = list(members)
