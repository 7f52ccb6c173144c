"""The figures that the paper prints, from paper.yaml."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any


@cache
def _printed() -> dict[str, Any]:
    from omegaconf import OmegaConf

    plain: Any = OmegaConf.to_container(OmegaConf.load(Path(__file__).with_name("paper.yaml")))
    return plain


def printed_mean(study: str, arm: str, place: str) -> float | None:
    """The mean fitness that the paper prints for an arm in a place (open_short, overall_long, ...), or None."""
    for one in _printed()["means"]:
        if (one["study"], one["arm"], one["place"]) == (study, arm, place):
            return float(one["value"])
    return None


def tuning() -> dict[str, dict[str, float]]:
    """By cell, the paper's mean and sd of the designed behaviour over the three instances on which it was tuned."""
    return {cell: {name: float(one[name]) for name in ("mean", "sd")} for cell, one in _printed()["tuning"].items()}


def tuning_means() -> dict[str, float]:
    """By cell, the mean alone."""
    return {cell: one["mean"] for cell, one in tuning().items()}
