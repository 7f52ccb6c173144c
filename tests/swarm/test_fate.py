"""What transmissions are lost to: worked cases, and agreement with what the air says in crowded steps."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from slcs2_jax.swarm.fate import Fate, fates

fates = jax.jit(fates)
STRONG, NEAR_NOISE, WEAK = 1e-7, 10**-8.1, 10**-8.3  # mW; P_rs is 10^-8.2, the noise 10^-9.4, the least SINR 10


def fate_of(make, power, *, jamming=0.0, holding=(0,), more=None):
    """The fate of what agent 0 sends to agent 1 on the first channel, and the whole table."""
    arena = make.arena([(0, 0), (10, 0), (20, 0)])
    state = make.state(arena, holding=list(holding))
    jammed = np.zeros((1, 5), np.float32)
    jammed[0, 1] = jamming
    links = make.links(3, power, jamming=jammed)
    physics = make.physics()
    _, air = make.transfer(state, links, make.intent(3, sends={0: (1, 0, 1.0), **(more or {})}), physics.radio)
    table = np.array(fates(air, links, physics.radio))
    return Fate(table[0, 0, 1]), table


@pytest.mark.parametrize(
    ("power", "options", "expected"),
    [
        ({(0, 1): STRONG}, {}, Fate.DELIVERED),
        ({(0, 1): WEAK}, {}, Fate.WEAK),
        ({(0, 1): WEAK}, {"jamming": 1e-6}, Fate.WEAK),  # it would have been lost without the jammer
        ({(0, 1): STRONG}, {"jamming": 2e-8}, Fate.JAMMED),
        ({(0, 1): STRONG}, {"jamming": 5e-9}, Fate.DELIVERED),
        ({(0, 1): STRONG, (2, 1): 2e-8}, {"holding": (0, 2), "more": {2: (4, 0, 1.0)}}, Fate.INTERFERENCE),
        ({(0, 1): STRONG, (2, 1): 5e-9}, {"holding": (0, 2), "more": {2: (4, 0, 1.0)}}, Fate.DELIVERED),
        # neither jammer nor neighbour would have sufficed alone
        (
            {(0, 1): STRONG, (2, 1): 6e-9},
            {"holding": (0, 2), "more": {2: (4, 0, 1.0)}, "jamming": 6e-9},
            Fate.INTERFERENCE,
        ),
        ({(0, 1): STRONG}, {"holding": (0, 1)}, Fate.REFUSED),
    ],
)
def test_the_first_sufficient_reason_counts(make, power, options, expected):
    assert fate_of(make, power, **options)[0] is expected


def test_what_is_not_sent_has_no_fate(make):
    _, table = fate_of(make, {(0, 1): STRONG})
    table[0, 0, 1] = Fate.NONE
    assert not table.any()
    assert not fate_of(make, {(0, 1): STRONG}, holding=())[1].any()
