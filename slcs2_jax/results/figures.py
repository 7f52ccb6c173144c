"""What was learnt of every rule: quality, strength, error and usage, declared once. [n, R] = agents, rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config.errors import InputError


@dataclass(frozen=True, eq=False, kw_only=True)
class Figures:
    """Figures of every rule at the end of an episode, or their means over several (paper, Rule Evaluation)."""

    quality: NDArray[np.float32]  # [n, R] q
    strength: NDArray[np.float32]  # [n, R] zeta, already divided by usage
    error: NDArray[np.float32]  # [n, R] epsilon
    usage: NDArray[np.int32 | np.float32]  # [n, R] tau, time-steps in an action set; a mean is a float

    @property
    def shape(self) -> tuple[int, ...]:
        """Agents and rules."""
        return self.strength.shape

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays by name."""
        return {name: getattr(self, name) for name in FIGURES}

    def check(self, name: str) -> None:
        """Raise InputError naming field, agent and rule where a shape is wrong, or a number not finite or negative."""
        if len(self.shape) != 2:
            raise InputError(f"{name}: strength has shape {self.shape}; [agents, rules] is required")
        for field, array in self.arrays().items():
            check_numbers(name, field, array, self.shape, negative=field != "usage")

    @classmethod
    def mean_of(cls, figures: Sequence[Figures]) -> Figures:
        """The means, float32, computed in float64."""

        def mean(name: str) -> NDArray[np.float32]:
            return np.stack([getattr(one, name) for one in figures]).mean(axis=0, dtype=np.float64).astype(np.float32)

        return cls(**{name: mean(name) for name in FIGURES})

    @classmethod
    def stacked(cls, figures: Sequence[Figures], shape: tuple[int, ...]) -> dict[str, NDArray[Any]]:
        """The arrays of several, [m, n, R]; of none, empty ones for this shape [n, R]."""
        if figures:
            return {name: np.stack([getattr(one, name) for one in figures]) for name in FIGURES}
        return {name: np.empty((0, *shape), np.int32 if name == "usage" else np.float32) for name in FIGURES}

    @classmethod
    def taken(cls, stacked: Mapping[str, NDArray[Any]], place: int) -> Figures:
        """One of those that `stacked` was given."""
        return cls(**{name: stacked[name][place].copy() for name in FIGURES})


FIGURES = tuple(field.name for field in fields(Figures))


def check_numbers(name: str, field: str, array: NDArray[Any], shape: tuple[int, ...], *, negative: bool) -> None:
    """Raise InputError naming the place unless the array has this shape and finite numbers (none below 0 if not
    `negative`); its axes are agents and rules."""
    array = np.asarray(array)
    if array.shape != shape:
        raise InputError(f"{name}: {field} has shape {array.shape}; {shape} is required")
    bad = ~np.isfinite(array)
    if not negative:
        bad |= array < 0
    if bad.any():
        agent, *rule = np.argwhere(bad)[0]
        place = f"agent {agent}" + (f", rule {rule[0]}" if rule else "")
        raise InputError(
            f"{name}: {field} of {place} is {array[(agent, *rule)]}; finite numbers are required"
            + ("" if negative else ", none below 0")
        )
