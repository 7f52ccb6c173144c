"""An episode packed for the page: thinned to some thousand frames, in bytes that a browser can read.

Layout: uint32 length of the header, the header (JSON), then the sections that it lists, one after the other; all little
endian, and the whole compressed by zlib. F frames, n agents, P transmissions. A frame shows a moment, with what went
over the air in the steps since the frame before it. Sections:

    moments int32 [F]; waiting, delivered int32 [F]; starts int32 [F + 1], transmissions of frame f are starts[f] to
    before starts[f + 1]; x, y int16 [n, F], in units of `unit` m, as differences from frame to frame modulo 2^16;
    holding uint8 [n, F]; rule int16 [n, F] and action uint8 [n, F] of the step that led to the moment, -1 and 255 for
    none; down uint8 [n, F]; jammer_x, jammer_y int16 [J, F], as x and y; jammed int8 [J, F], channel (its number) that
    each jammer emitted on then, -1 for none; heard uint8 [F, bytes],
    bits [n + 2 node, n agent] of that step, the lowest first; sender, receiver, fate uint8 [P].
"""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.grammar.vocabulary import NO_ACTION
from slcs2_jax.looking.recording import NOBODY, Recording
from slcs2_jax.looking.traffic import telling, traffic

MOST_FRAMES = 5000
MOST_PLACES = 60_000  # frames times agents
FINEST = 0.1  # m, unit of places
LARGEST = 32_000  # units that a place may be from the source: an int16 holds a little more


def frame_moments(steps: int, agents: int) -> NDArray[np.int32]:
    """The moments that are shown, evenly spaced from the first to the last: int32 [F]."""
    most = min(MOST_FRAMES, MOST_PLACES // agents)
    every = max(1, -(-steps // (most - 1)))
    return np.array([*range(0, steps, every), steps], np.int32)


def pack_replay(recording: Recording) -> bytes:
    """The episode as the page reads it; see the head of this file."""
    moments = frame_moments(recording.steps, recording.agents)
    before = np.maximum(moments - 1, 0)  # the step that led to each moment
    places = [recording.x, recording.y, recording.jammer_x, recording.jammer_y]
    unit = max(FINEST, max(float(np.abs(one).max(initial=0)) for one in places) / LARGEST)
    jammed = recording.jammed[before]
    sections: dict[str, NDArray[Any]] = {
        "moments": moments,
        "waiting": recording.waiting[moments].astype(np.int32),
        "delivered": recording.delivered[moments].astype(np.int32),
        "x": _differences(recording.x[moments], unit),
        "y": _differences(recording.y[moments], unit),
        "holding": recording.holding[moments].T.astype(np.uint8),
        "rule": _acted(recording.rule[before], NOBODY).astype(np.int16),
        "action": _acted(recording.action[before], NO_ACTION).astype(np.uint8),
        "down": recording.down[moments].T.astype(np.uint8),
        "jammer_x": _differences(recording.jammer_x[moments], unit),
        "jammer_y": _differences(recording.jammer_y[moments], unit),
        "jammed": np.where(jammed == NOBODY, NOBODY, np.array(recording.vocabulary.channels)[jammed]).T.astype(np.int8),
        "heard": np.stack([_bits(recording.neighbours(step)) for step in before.tolist()]),
        **_transmissions(recording, moments),
    }
    header = _header(recording, moments, unit)
    header["sections"] = [[name, array.dtype.name, array.size] for name, array in sections.items()]
    head = json.dumps(header, allow_nan=False).encode()
    parts = [np.uint32(len(head)).astype("<u4").tobytes(), head]
    parts += [np.ascontiguousarray(array, array.dtype.newbyteorder("<")).tobytes() for array in sections.values()]
    return zlib.compress(b"".join(parts), 9)


def _header(recording: Recording, moments: NDArray[np.int32], unit: float) -> dict[str, Any]:
    scenario, settings = recording.scenario, recording.settings
    used = sorted(set(np.unique(recording.action).tolist()) - {NO_ACTION})
    return {
        "agents": recording.agents,
        "frames": len(moments),
        "steps": recording.steps,
        "time_limit": scenario.time_limit,
        "packets": settings.swarm.packets,
        "fitness": round(recording.fitness, 5),
        "unit": unit,
        "sink": _plain(scenario.sink),
        "reach": [round(recording.reach(jammer), 2) for jammer in range(len(scenario.jammers))],
        "vertical": _plain(scenario.vertical),
        "horizontal": _plain(scenario.horizontal),
        "thickness": scenario.wall_thickness,
        "actions": {str(action): recording.vocabulary.action_text(action) for action in used},
    }


def _differences(places: NDArray[np.float32], unit: float) -> NDArray[np.int16]:
    """[F, n] m -> [n, F], from frame to frame, the first from 0; modulo 2^16."""
    whole = np.rint(places.T.astype(np.float64) / unit).astype(np.int32)
    return np.diff(whole, axis=1, prepend=0).astype(np.uint32).astype(np.uint16).view(np.int16)


def _acted(values: NDArray[Any], none: int) -> NDArray[Any]:
    """[F, n] -> [n, F]; before the first step nobody has acted."""
    acted = values.T.astype(np.int32)
    acted[:, 0] = none
    return acted


def _bits(flags: NDArray[np.bool_]) -> NDArray[np.uint8]:
    return np.packbits(flags, axis=None, bitorder="little")


def _transmissions(recording: Recording, moments: NDArray[np.int32]) -> dict[str, NDArray[Any]]:
    """Every pair of nodes that attempted anything since the frame before, with the most telling fate."""
    found: list[tuple[int, int, int]] = []
    starts = [0, 0]  # nothing came before the first frame
    for start, stop in zip(moments[:-1].tolist(), moments[1:].tolist(), strict=True):
        found += telling(traffic(recording, start, stop))
        starts.append(len(found))
    columns = np.array(found, np.uint8).reshape(-1, 3).T
    return {
        "starts": np.array(starts, np.int32),
        "sender": columns[0],
        "receiver": columns[1],
        "fate": columns[2],
    }


def _plain(array: NDArray[np.float32]) -> Any:
    return np.round(array.astype(np.float64), 2).tolist()
