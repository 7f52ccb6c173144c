"""What went over the air in a span of an episode, summed up."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.looking.recording import NOBODY, Recording
from slcs2_jax.swarm.fate import Fate

# If several attempts between the same two are shown as one, the first of these that occurred.
TELLING = (Fate.DELIVERED, Fate.JAMMED, Fate.INTERFERENCE, Fate.REFUSED, Fate.WEAK)


def traffic(recording: Recording, start: int, stop: int) -> NDArray[np.int64]:
    """Transmissions of the steps from `start` to before `stop`: int64 [n + 1 sender, n + 2 receiver, 6 `Fate`]."""
    n = recording.agents
    counts = np.zeros((n + 1, n + 2, len(Fate)), np.int64)
    step, agent = np.nonzero(recording.sent_to[start:stop] != NOBODY)
    step += start
    _count(counts, agent, recording.sent_to[step, agent], recording.sent_fate[step, agent])
    step, channel = np.nonzero(recording.served[start:stop] != NOBODY)
    step += start
    served, fate = recording.served[step, channel], recording.served_fate[step, channel]
    _count(counts, np.full_like(step, recording.source), served, fate)
    return counts


def _count(counts: NDArray[np.int64], *places: NDArray[Any]) -> None:
    np.add.at(counts, tuple(place.astype(np.intp) for place in places), 1)


def telling(counts: NDArray[np.int64]) -> list[tuple[int, int, Fate]]:
    """Of what `traffic` returns, each pair that attempted anything with the most telling thing that came of it."""
    found = []
    for sender, receiver in np.argwhere(counts.any(axis=2)).tolist():
        fate = next(fate for fate in TELLING if counts[sender, receiver, fate])
        found.append((sender, receiver, fate))
    return found
