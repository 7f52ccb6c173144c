"""Which member is explored next (paper, Behaviour Evolution; docs/model.md)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slcs2_jax.search.member import Member
from slcs2_jax.search.problem import Problem


class FewestExplorations:
    """The member with the fewest explorations phi, the newest on ties. Draws nothing."""

    def __init__(self, problem: Problem) -> None:
        """Nothing of the problem matters."""

    def __call__(self, members: Sequence[Member], rng: np.random.Generator) -> Member:
        """See `ParentChoice`."""
        return min(members, key=lambda member: (member.explorations, -member.generation))


class Uniform:
    """Any member, each with the same chance."""

    def __init__(self, problem: Problem) -> None:
        """Nothing of the problem matters."""

    def __call__(self, members: Sequence[Member], rng: np.random.Generator) -> Member:
        """See `ParentChoice`."""
        return members[int(rng.integers(len(members)))]
