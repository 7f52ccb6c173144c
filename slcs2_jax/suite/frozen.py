"""What makes two worlds the same: one checksum over all that decides, the same on every machine.

Lengths are taken to the millimetre, so that the last bit of a logarithm or a power, which machines compute differently,
decides nothing; so are settings taken to twelve digits.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from slcs2_jax.world.layout import Scenario

_PER_METRE = 1000


def digest(stated: Mapping[str, Any], scenarios: Iterable[Scenario]) -> str:
    """SHA-256, hex, of settings by their paths and of the worlds that they make, in order."""
    found = hashlib.sha256()
    found.update(json.dumps({name: _plain(stated[name]) for name in sorted(stated)}, sort_keys=True).encode())
    for scenario in scenarios:
        found.update(canonical(scenario))
    return found.hexdigest()


def canonical(scenario: Scenario) -> bytes:
    """A scenario as bytes: seed, sink, its estimate, time limit, walls, starts and jammers."""
    arrays = [scenario.sink, scenario.sink_estimate, scenario.vertical, scenario.horizontal, scenario.start]
    said: dict[str, Any] = {
        "seed": scenario.seed,
        "time_limit": int(scenario.time_limit),
        "wall_thickness": _plain(float(scenario.wall_thickness)),
        "shapes": [list(array.shape) for array in arrays],
        "jammers": [
            {
                name: _plain(getattr(jammer, name))
                for name in ("emission", "motion", "power_db", "speed", "duty", "dwell")
            }
            | {"route": len(jammer.route)}
            for jammer in scenario.jammers
        ],
    }
    arrays += [array for jammer in scenario.jammers for array in (jammer.place, jammer.route)]
    places = b"".join(_millimetres(array).tobytes() for array in arrays)
    return json.dumps(said, sort_keys=True).encode() + places


def _millimetres(array: np.ndarray) -> np.ndarray:
    return np.rint(np.asarray(array, np.float64) * _PER_METRE).astype("<i8")


def _plain(value: Any) -> Any:
    """Numbers as text, whole or not, so that 2 and 2.0 are one."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return value
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return f"{float(value):.12g}"
