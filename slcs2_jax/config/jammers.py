"""The settings of jammers in worlds made from a seed (docs/model.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slcs2_jax.config.field import LEAST, Section, setting

MOST_JAMMERS = 16
MOST_POINTS = 16  # of a patrol


@dataclass(frozen=True)
class Jammers(Section):
    """Jammers where the environment has any. One, reactive and fixed, is the paper's."""

    SECTION: ClassVar[str] = "jammers"

    count: int = setting(1, "jammers in a jammed world", status="paper", low=1, high=MOST_JAMMERS)
    emission: str = setting(
        "reactive", "when, and on which channel, a jammer transmits", status="paper", part="emission"
    )
    motion: str = setting("fixed", "how a jammer moves", status="paper", part="jammer motion")
    power_db: float = setting(
        0.0, "power relative to an agent's full power", unit="dB", status="paper", low=-200, high=200
    )
    speed: float = setting(2.0, "patrol, pursue: speed", unit="m/step", reason="an agent's", low=LEAST, high=1e3)
    duty: float = setting(
        0.5, "random: share of the intervals in which it transmits", reason="half of the time", low=0, high=1
    )
    dwell: int = setting(
        10, "random, sweeping: steps of an interval, of a channel", unit="steps", reason="the sharing period",
        low=1, high=10**6,
    )  # fmt: skip
    patrol_points: int = setting(
        2, "patrol: points that it goes round; the first is its place at the start", reason="there and back",
        low=2, high=MOST_POINTS,
    )  # fmt: skip
    margin_db: float | None = setting(
        None,
        "how far below the noise its mean power is at source and sink, at the least; null as the paper: it is farther "
        "than net along the line, and still raises the noise there",
        unit="dB",
        status="paper",
        low=0,
        high=100,
    )
