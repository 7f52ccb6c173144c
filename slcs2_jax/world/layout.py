"""What a scenario consists of: source, sink, walls, jammers and first places (model section 2)."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


def _nowhere() -> Floats:
    return np.zeros((0, 2), np.float32)


@dataclasses.dataclass(frozen=True, eq=False)
class Jammer:
    """One jammer; the defaults are the paper's.

    Attributes:
        place: float32 [2], m, where it starts.
        emission: when and where it transmits, a name of the registry.
        motion: how it moves, a name of the registry.
        power_db: relative to an agent's full power.
        speed: of patrol and pursue, m per step.
        duty: of random, share of the intervals in which it transmits.
        dwell: of random and sweeping, steps.
        route: float32 [P - 1, 2], m, where a patrol goes from its place before it comes back.
    """

    place: Floats
    emission: str = "reactive"
    motion: str = "fixed"
    power_db: float = 0.0
    speed: float = 2.0
    duty: float = 0.5
    dwell: int = 10
    route: Floats = dataclasses.field(default_factory=_nowhere)

    @property
    def plain(self) -> bool:
        """Whether it is the paper's, but for its place."""
        return self.emission == "reactive" and self.motion == "fixed" and self.power_db == 0


@dataclasses.dataclass(frozen=True, eq=False)
class Scenario:
    """One environment instance; lengths in m.

    Attributes:
        environment: type of environment.
        seed: what it was made from, beside the settings.
        sink: float32 [2]; the source is the origin.
        sink_estimate: float32 [2], where the agents believe the sink to be.
        jammers: none, one, or several.
        vertical: float32 [V, 3], walls (x, lowest y, highest y) of the centre lines.
        horizontal: float32 [H, 3], walls (y, lowest x, highest x).
        wall_thickness: of every wall.
        start: float32 [n, 2], the agents' first positions.
        time_limit: T, time-steps.
    """

    environment: str
    seed: int
    sink: Floats
    sink_estimate: Floats
    jammers: tuple[Jammer, ...]
    vertical: Floats
    horizontal: Floats
    wall_thickness: float
    start: Floats
    time_limit: int

    @property
    def jammer(self) -> Floats | None:
        """Where the first jammer starts, float32 [2]; None if there is none. The paper's worlds have no other."""
        return self.jammers[0].place if self.jammers else None

    @property
    def walls(self) -> int:
        """Number of walls."""
        return len(self.vertical) + len(self.horizontal)
