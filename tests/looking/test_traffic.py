"""Transmissions summed up: each of them once, with what came of it."""

from __future__ import annotations

import numpy as np

from slcs2_jax.looking.traffic import TELLING, telling, traffic
from slcs2_jax.swarm.fate import Fate


def test_every_transmission_of_the_span_is_counted_once(episode, jammed_episode):
    for one in (episode, jammed_episode):
        counts = traffic(one, 20, 120)
        for step in range(20, min(120, one.steps)):
            for sent in one.transmissions(step):
                counts[sent.sender, sent.receiver, sent.fate] -= 1
        assert not counts.any()
        assert traffic(one, 0, one.steps).sum() > 10


def test_a_pair_is_shown_with_the_most_telling_of_its_fates():
    counts = np.zeros((3, 4, len(Fate)), np.int64)
    counts[0, 1, Fate.WEAK] = 9
    counts[0, 1, Fate.JAMMED] = 1
    counts[2, 0, Fate.DELIVERED] = 1
    counts[2, 0, Fate.INTERFERENCE] = 5
    assert telling(counts) == [(0, 1, Fate.JAMMED), (2, 0, Fate.DELIVERED)]
    assert set(TELLING) == set(Fate) - {Fate.NONE}
