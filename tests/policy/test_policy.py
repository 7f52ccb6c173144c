"""A user's policy that gives something else than it should is named in one line."""

from __future__ import annotations

import jax.numpy as jnp
import pytest

import slcs2_jax as slcs2
from slcs2_jax.config import InputError

SETTINGS = slcs2.Settings(world=slcs2.World(distance=190.0, time_limit=20), swarm=slcs2.Swarm(agents=3, packets=2))


class Odd(slcs2.Policy):
    def __init__(self, decide):
        self.given = decide

    def initial_memory(self, parameters, agents, learning):
        return jnp.zeros(agents.shape, jnp.int32)

    def decide(self, memory, parameters, seen, clock, learning):
        return self.given(memory, seen.view)


@pytest.mark.parametrize(
    ("decide", "said"),
    [
        (lambda memory, view: (memory, view.x), "policy 'Odd': returned float32"),
        (lambda memory, view: (memory, jnp.zeros((7,), jnp.int32)), r"policy 'Odd': returned int32\[7\]"),
        (lambda memory, view: (memory, 3), "policy 'Odd': returned int"),
        (lambda memory, view: memory, "decide returned .*; accepted are a memory and actions"),
        (lambda memory, view: (memory[0], memory), "its memory changes its shape"),
        (lambda memory, view: (memory.astype(jnp.float32), memory), "its memory changes its shape or type"),
        (lambda memory, view: ((memory,), memory), "its memory changes its shape"),
    ],
)
def test_it_is_named(decide, said):
    policy = slcs2.bind(Odd(decide), ())
    with pytest.raises(InputError, match=said) as caught:
        slcs2.Evaluator(SETTINGS)([policy], [0])
    assert "\n" not in str(caught.value)


def test_what_it_should_give_is_taken():
    policy = slcs2.bind(Odd(lambda memory, view: (memory + 1, memory)), ())
    assert slcs2.Evaluator(SETTINGS)([policy], [0]).steps.tolist() == [[[20]]]
